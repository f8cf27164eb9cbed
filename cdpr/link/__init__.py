"""Talking with a program in another process: how it is started or found, and the frames that go to and fro.

The other side is a peer. It is greeted by one line of JSON, answers with one, and then exchanges frames of
little-endian 64-bit floats whose lengths the greeting says; the first number of each is its sequence, from 0 by 1.
Nothing that it says is believed: sequences, lengths and numbers are checked, and one that is silent for longer than its
time-out, ends, or breaks a rule ends the run with `BackendDied`. docs/remote.md describes it for who writes a peer.
"""
