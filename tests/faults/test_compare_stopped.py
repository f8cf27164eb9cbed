"""Comparisons and baselines that are interrupted or terminated: no process and no temporary folder stays."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from compare_cases import ENGINES, SCENARIOS
from conftest import ROOT

from cdpr.base.checksums import KEY, sealed

CAROCA = str(SCENARIOS / "caroca.yaml")
LONG = ("--set", "simulation.duration=3600")


def endless(folder):
    """A baseline whose run takes for ever."""
    data = json.loads((ROOT / "tests/regression/baselines/caroca_reference.baseline.json").read_text())
    lines = data["scenario_yaml"]
    (place,) = (i for i, line in enumerate(lines) if line.startswith("  duration: ") and "control" in lines[i + 1])
    lines[place] = "  duration: 3600.0"
    path = folder / "endless.baseline.json"
    del data[KEY]
    path.write_text(json.dumps(sealed(data | {"source": "nowhere.yaml"})))
    return str(path)


COMMANDS = {
    "compare": lambda folder: ("compare", CAROCA, "--backends", ENGINES[0], *LONG),
    "compare --out": lambda folder: (*COMMANDS["compare"](folder), "--out", str(folder / "tmp" / "kept")),
    "save": lambda folder: ("baseline", "save", CAROCA, "--out", str(folder / "kept"), *LONG),
    "check": lambda folder: ("baseline", "check", endless(folder)),
}


@pytest.mark.parametrize(
    ("command", "number", "code"),
    [
        pytest.param("compare", signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param("compare", signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param("compare --out", signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param("save", signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param("check", signal.SIGHUP, 143, marks=pytest.mark.slow),
    ],
)
def test_nothing_stays(tmp_path, command, number, code):
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "cdpr", *COMMANDS[command](tmp_path)],
        env={**os.environ, "TMPDIR": str(temporary)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # the tests may run under nohup
    )
    deadline = time.monotonic() + 120
    while not any(log.stat().st_size > 20_000 for log in temporary.glob("*/**/log.mcap")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(number)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == code
    assert "Traceback" not in errors
    assert not output
    assert not (tmp_path / "kept").exists()
    time.sleep(0.2)  # a worker that continued would write again
    assert os.listdir(temporary) == []
