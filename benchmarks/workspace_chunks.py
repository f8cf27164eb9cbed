"""A hundred million poses to disk: peak memory, and whether a run that was killed has the bits of one that was not.

The capacity margin of CoGiRo with a box of required wrenches, at 464 x 464 x 465 cells, by `cdpr workspace`, in
processes of its own: once killed after a third and resumed, once on one thread and not stopped. Takes some minutes, and
twice the disk space that it prints. Run: python benchmarks/workspace_chunks.py [--cells NX,NY,NZ] [--json].
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from math import prod
from pathlib import Path

ROBOT = Path(__file__).parent.parent / "scenarios" / "robots" / "cogiro.yaml"
CELLS = "464,464,465"
HALF = "50,50,50,5,5,5"  # N, N m
CHUNK = 524288  # cells


def run(folder: Path, cells: str, *options: str, killed_after: int | None = None) -> tuple[float, float]:
    """Compute into a folder, or kill it after this many chunks; return seconds and peak memory, MiB."""
    words = [sys.executable, "-m", "cdpr", "workspace", "wrench-feasible", str(ROBOT), "--wrench-box", HALF]
    words += ["--cells", cells, "--chunks", str(folder), *options]
    started = time.perf_counter()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if killed_after is not None:
        ledger = folder / "cases.jsonl"
        while not ledger.exists() or ledger.read_bytes().count(b"\n") < killed_after:
            time.sleep(0.05)
        process.kill()
    _, status, used = os.wait4(process.pid, 0)
    if killed_after is None and status:
        sys.exit(f"{' '.join(words)}: ended with status {status}")
    return time.perf_counter() - started, used.ru_maxrss / 1024


def bits(folder: Path) -> str:
    """A digest of the summary and of all chunks."""
    found = hashlib.sha256()
    for file in [folder / "summary.json", *sorted((folder / "chunks").iterdir())]:
        found.update(file.name.encode() + file.read_bytes())
    return found.hexdigest()


def measured(cells: str) -> dict[str, object]:
    """Run both."""
    count = prod(map(int, cells.split(",")))
    with tempfile.TemporaryDirectory() as root:
        stopped, whole = Path(root) / "stopped", Path(root) / "whole"
        first = run(stopped, cells, killed_after=max(1, count // CHUNK // 3))
        second = run(stopped, cells, "--resume")
        alone = run(whole, cells, "--jobs", "1")
        size = sum(file.stat().st_size for file in whole.rglob("*"))
        return {
            "poses": count,
            "gib_on_disk": size / 2**30,
            "peak_mib": max(first[1], second[1], alone[1]),
            "seconds_killed_and_resumed": first[0] + second[0],
            "seconds_on_one_thread": alone[0],
            "same_bits": bits(stopped) == bits(whole),
            "share": json.loads((whole / "summary.json").read_text())["share"],
        }


def main() -> None:
    cells = sys.argv[sys.argv.index("--cells") + 1] if "--cells" in sys.argv else CELLS
    found = measured(cells)
    if "--json" in sys.argv:
        print(json.dumps(found, indent=1))
        return
    print(f"{found['poses']:.3g} poses, {found['gib_on_disk']:.3g} GiB on disk, load {os.getloadavg()[0]:.2g}")
    print(f"  peak memory           {found['peak_mib']:.0f} MiB")
    print(f"  killed and resumed    {found['seconds_killed_and_resumed']:.0f} s")
    print(f"  one thread            {found['seconds_on_one_thread']:.0f} s")
    print(f"  same bits             {found['same_bits']}")


if __name__ == "__main__":
    main()
