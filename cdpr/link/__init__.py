"""Communication with a peer program in another process: start or connection, greeting, and binary frames.

Both sides first exchange one line of JSON, the greeting, and then frames of little-endian 64-bit floats with the
lengths given there. The first number of each frame is its sequence number, counted from 0. All data from the peer is
checked. A peer that exceeds its time-out, ends or violates the protocol ends the run with `BackendDied`. docs/remote.md
describes the protocol for authors of peers.
"""
