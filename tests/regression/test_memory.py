"""A long logged run, its report and its exports need the memory of a short one."""

from __future__ import annotations

import subprocess
import sys

import pytest
from conftest import ROOT

SHORT, LONG, HOUR = 60.0, 300.0, 3600.0  # s, simulated at 1 kHz
MOST = 400.0  # MB, of an hour
# MB by which the peak of an export may differ: an allocator under texts of numbers differs by 30 from run to run (more
# rows may need less), and the rows that the long run has more are above 100.
NOISE = 60.0
CDPR = [sys.executable, "-m", "cdpr"]


# A process begins with the largest memory of the one that starts it: this one is small.
MEASURE = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def peak(*arguments: object) -> float:
    """Largest resident memory of a command, MB."""
    command = [sys.executable, "-c", MEASURE, *CDPR, *map(str, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return int(done.stdout) * 1024 / 1e6


@pytest.mark.slow
def test_an_hour_at_1_khz_fits_into_400_mb(tmp_path):
    """An hour writes 7 GB, so two shorter runs measure the memory per second, and that of exports.

    Only data of the summary grows with the run, 17 B per sample, and the index of the log's blocks.
    """
    commands = {
        "run": ("run", ROOT / "scenarios" / "caroca.yaml", "--backend", "reference"),
        "csv": ("export", "--to", "csv", "--force"),
        "npz": ("export", "--to", "npz", "--force"),
        "parquet": ("export", "--to", "parquet", "--force"),
    }
    warm_up = ("--set", "simulation.duration=1", "--out", tmp_path / "warm-up")
    peak(*commands["run"], *warm_up)  # what compiles needs memory of its own
    used: dict[str, dict[float, float]] = {name: {} for name in commands}
    for duration in (SHORT, LONG):
        folder = tmp_path / f"{duration:g}"
        for name, words in commands.items():
            given = ["--set", f"simulation.duration={duration}", "--out", folder]
            if name != "run":
                given = [folder, "--out", tmp_path / "export"]
            used[name][duration] = peak(*words, *given)
    assert 50.0 < max(at[LONG] for at in used.values()) < MOST, used
    assert all(at[LONG] - at[SHORT] < NOISE for at in used.values()), used
    growth = max((used["run"][LONG] - used["run"][SHORT]) / (LONG - SHORT), 0.0)  # MB/s
    assert used["run"][LONG] + growth * (HOUR - LONG) < MOST, used
