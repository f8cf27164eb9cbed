"""Cost of a row of the log, in microseconds and in units of one numpy pinv of a 6x8 matrix."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np

import cdpr
from cdpr.log.blocks import BLOCK
from cdpr.log.checksum import crc32
from cdpr.log.chunk import CHUNK_HEAD
from cdpr.log.chunk_index import Written
from cdpr.log.export import export
from cdpr.log.finite import Finite
from cdpr.log.header import Header
from cdpr.log.mcap_file import PICTURE_ROWS, LogFormat, Piece
from cdpr.log.reader import load_run
from cdpr.log.recorder import Recorder
from cdpr.model.robot import Array

ROWS = 100 * BLOCK
ROUNDS = 15


def moving() -> tuple[Header, Array]:
    """Return the header and the rows (ROWS, width) of a robot with eight cables that moves all the time."""
    seconds = 0.001 * (ROWS - 1)
    run = cdpr.simulate("caroca", overrides={"simulation.duration": seconds, "trajectory.duration": seconds})
    return run.header, np.ascontiguousarray(run.rows[:])


def random(header: Header) -> Array:
    """Return rows (ROWS, width) of random numbers."""
    rows = np.random.default_rng(0).standard_normal((ROWS, header.layout.width))
    rows[:, 0] = np.arange(ROWS) * header.control_step
    return rows


def measure(header: Header, rows: Array, where: str | None = None) -> dict[str, dict[str, float]]:
    """Minima by name: microseconds of processor time a row, and the ratio to the pinv measured just before."""
    matrix = np.random.default_rng(0).standard_normal((6, 8))
    form = LogFormat(header)
    old = LogFormat(header, version="3")  # without compression
    block = memoryview(bytes(form.block(rows[:BLOCK], 0)))
    size = form.templates[0].chunk_length(BLOCK)
    content = bytes(block[CHUNK_HEAD.size : size])
    base = Path(tempfile.mkdtemp(dir=where))
    fresh = iter(range(10**6))

    def record(folder: Path) -> float:
        folder.mkdir(exist_ok=True)
        recorder = Recorder(header, ROWS - 1, folder)
        recorder.rows[:] = rows
        started = process_time()
        for n in range(BLOCK, ROWS + 1, BLOCK):
            recorder.flush(n)
        recorder.close(ROWS)
        return (process_time() - started) / ROWS

    def uncompressed(path: Path) -> float:
        """Check and write rows as versions before format 4 did, without a thread."""
        finite = Finite(header.layout, header.control_step)
        chunks: list[Written] = []
        with path.open("wb", buffering=0) as file:
            file.write(old.description)
            started = process_time()
            for n in range(BLOCK, ROWS + 1, BLOCK):
                finite.take(rows, n)
                first = n - BLOCK
                pieces = [Piece(0, first, BLOCK, old.block(rows[first:n], first))]
                if n % PICTURE_ROWS == 0 or n == ROWS:
                    first = (n - 1) // PICTURE_ROWS * PICTURE_ROWS
                    pieces += old.pictures(rows[first:n], first)
                for piece in pieces:
                    _, written = old.stored(piece, file.tell())
                    chunks.append(written)
                    file.write(piece.raw)
            file.write(old.ending(chunks, ROWS - 1, file.tell()))
            return (process_time() - started) / ROWS

    def close(folder: Path) -> float:
        recorder = Recorder(header, ROWS - 1, folder)
        recorder.rows[:] = rows
        recorder.flush(ROWS)
        return timed(lambda: recorder.close(ROWS), 1) / ROWS

    def table() -> float:
        run = load_run(base / "same")
        return timed(lambda: export(run, "csv", base / "table.csv", True), 1) / ROWS

    parts: dict[str, Callable[[], float]] = {
        "encode and checksum": lambda: timed(lambda: form.block(rows[:BLOCK], 0), 40) / BLOCK,
        "  of it the checksum": lambda: timed(lambda: crc32(content), 40) / BLOCK,
        "compress": lambda: timed(lambda: form.stored(Piece(0, 0, BLOCK, block), 0), 10) / BLOCK,
        "uncompressed, new file": lambda: uncompressed(base / str(next(fresh))),
        "record, file written over": lambda: record(base / "same"),
        "record, new file": lambda: record(base / str(next(fresh))),
        "close": lambda: close(base / "same"),
        "load": lambda: timed(lambda: load_run(base / "same"), 1) / ROWS,
        "CSV": table,
    }
    cost: dict[str, list[float]] = {name: [] for name in parts}
    pinv = []
    try:
        record(base / "same")
        for _ in range(ROUNDS):
            for name, part in parts.items():
                pinv.append(timed(lambda: np.linalg.pinv(matrix), 300))
                cost[name].append(part())
    finally:
        shutil.rmtree(base)
    return {name: {"us_per_row": 1e6 * min(cost[name]), "pinv_per_row": min(cost[name]) / min(pinv)} for name in parts}


def timed(call: Callable[[], object], repeats: int) -> float:
    """Seconds of processor time a call, of all threads."""
    started = process_time()
    for _ in range(repeats):
        call()
    return (process_time() - started) / repeats


if __name__ == "__main__":
    header, rows = moving()
    for case, table in {"moving": rows, "random": random(header)}.items():
        print(case)
        for name, figures in measure(header, table, sys.argv[1] if len(sys.argv) > 1 else None).items():
            print(f"{name:28} {figures['us_per_row']:6.2f} us a row {figures['pinv_per_row']:8.4f} pinv")
