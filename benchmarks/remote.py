"""Cost of a step with a controller in another process, in units of one numpy.linalg.pinv of a 6x8 matrix."""

from __future__ import annotations

import json
import socket
import sys
import tempfile
import threading
from hashlib import sha256
from pathlib import Path
from time import perf_counter

import numpy as np

from cdpr.link.options import PeerOptions
from cdpr.link.peer import Peer

SENDS, TAKES = 49, 6  # numbers of a controller of eight cables
TRIPS = 5000
PINV_CALLS = 200
ECHO = """
import json, sys
inp, out = sys.stdin.buffer, sys.stdout.buffer
size = json.loads(inp.readline())["sends"] * 8
out.write(b'{"cdpr": 1}\\n'); out.flush()
while len(data := inp.read(size)) == size:
    out.write(data[:56]); out.flush()
"""


def answer(listening: socket.socket) -> None:
    """Echo one run."""
    peer, _ = listening.accept()
    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    with peer, peer.makefile("rb") as stream:
        size = json.loads(stream.readline())["sends"] * 8
        peer.sendall(b'{"cdpr": 1}\n')
        while len(data := stream.read(size)) == size:
            peer.sendall(data[: 8 * (TAKES + 1)])


def trips(options: PeerOptions, program: Path | None) -> dict[str, float]:
    """Round trips, us."""
    peer, frame = Peer(options, program, {}, SENDS, TAKES), np.ones(SENDS)
    times = []
    for _ in range(TRIPS):
        start = perf_counter()
        peer.request(frame)
        times.append(1e6 * (perf_counter() - start))
    peer.close()
    return {"least": min(times), "median": float(np.median(times)), "p99": float(np.percentile(times, 99))}


def measured() -> dict[str, dict[str, float]]:
    """Return the figures of both ways."""
    matrix, least = np.random.default_rng(1).normal(size=(6, 8)), np.inf
    for _ in range(20):
        start = perf_counter()
        for _ in range(PINV_CALLS):
            np.linalg.pinv(matrix)
        least = min(least, (perf_counter() - start) / PINV_CALLS)
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "echo.py"
        program.write_text(ECHO)
        PeerOptions.model_rebuild()
        found = {"pipes": trips(PeerOptions.model_construct(sha256=sha256(program.read_bytes()).hexdigest()), program)}
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        threading.Thread(target=answer, args=(listening,), daemon=True).start()
        found["TCP"] = trips(PeerOptions(address=f"127.0.0.1:{listening.getsockname()[1]}"), None)
    for figures in found.values():
        figures["pinvs"] = figures["median"] / (1e6 * least)
    return found


if __name__ == "__main__":
    table = measured()
    if "--json" in sys.argv[1:]:
        print(json.dumps(table, indent=1))
    else:
        for name, figures in table.items():
            print(f"{name:<8}" + "   ".join(f"{key} {value:.3g}" for key, value in figures.items()) + "   (us)")
