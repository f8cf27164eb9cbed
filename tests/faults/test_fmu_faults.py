"""An FMU that misbehaves in the middle of a run: one line of error in time, all samples up to there, nothing left."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path
from time import monotonic

import numpy as np
import pytest
from conftest import ROOT
from fmu.faulty import FAULTS, FaultyPlant, write_faulty_fmu
from spread import sampled

from cdpr import load_run, simulate
from cdpr.base.errors import BackendDied, Diverged, ExitCode
from cdpr.fmu.read.archive import open_archive
from cdpr.scenario import load_scenario

pytest.importorskip("fmpy")

SCENARIO = ROOT / "scenarios/caroca.yaml"
TIMEOUT = 0.5  # s of wall time, given to the FMU
PATIENCE = 10.0  # s that a busy machine may take besides; what hangs does so for ever
START = 0.1  # s of simulated time at which it misbehaves

SAYS = {
    "discard": "DoStep returned Discard; its output: Discard: the step is discarded",
    "error": "DoStep returned Error; its output: Error: the winch is on fire",
    "fatal": "DoStep returned Fatal; its output: Fatal: nothing works any more",
    "segfault": "crashed: its process was ended by SIGSEGV",
    "abort": "crashed: its process was ended by SIGABRT",
    "exit": "ended its process with exit code 3",
    "hang": "took more than 0.5 s for this step and was stopped",
    "log": "took more than 0.5 s for this step and was stopped; its output: Warning: message ",
}


@pytest.fixture(autouse=True)
def own_temporary_folder(monkeypatch, tmp_path):
    """Other processes of this machine may run FMUs, too."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


@pytest.fixture(scope="module")
def options(tmp_path_factory):
    """Return the options for a fault, in FMI 2 or 3."""
    scenario, folder = load_scenario(SCENARIO), tmp_path_factory.mktemp("fault")
    plant = FaultyPlant(scenario.robot, scenario.gravity, 1e-3, scenario.initial.state())
    paths = {fmi: write_faulty_fmu(plant, fmi, folder / f"fault{fmi}.fmu") for fmi in (2, 3)}

    def make(fault, fmi=3, isolation="process"):
        parameters = {"fault": float(FAULTS.index(fault)), "fault_time": START}
        return {
            "file": str(paths[fmi]),
            "sha256": open_archive(paths[fmi]).sha256,
            "step_timeout": TIMEOUT,
            "isolation": isolation,
            "parameters": parameters,
        }

    return make


def left():
    """Temporary folders and workers of this process."""
    folders = {path.name for path in Path(tempfile.gettempdir()).glob("cdpr-fmu-*")}
    children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split()
    return folders, children


def run(options, **more):
    return simulate(
        SCENARIO, backend="fmu", overrides={"backend_options.fmu": options, "simulation.duration": 0.2}, **more
    )


@sampled(
    lambda fault, fmi: (fault, fmi) in (("segfault", 3), ("hang", 2)),
    "fault, fmi",
    list(product(SAYS, (2, 3))),
)
def test_a_fault_is_an_error_in_time(options, fault, fmi, tmp_path):
    before, here, began = left(), os.getcwd(), monotonic()
    with pytest.raises(BackendDied) as caught:
        run(options(fault, fmi), out=tmp_path / "run")
    spent, text = monotonic() - began, str(caught.value)
    assert SAYS[fault] in text
    assert text.startswith("t = 0.101 s: FMU '")
    assert "\n" not in text
    assert len(text) < 2000
    assert left() == before
    assert os.getcwd() == here
    kept = caught.value.run
    assert spent - kept.timings["setup_s"] < TIMEOUT + PATIENCE
    assert kept.status == "failed"
    assert len(kept.rows) == 101  # 0 to 0.1 s
    logged = load_run(tmp_path / "run")
    np.testing.assert_array_equal(logged.rows, kept.rows)
    assert logged.plugins["backend"]["sha256"] == options(fault, fmi)["sha256"]


@pytest.mark.parametrize("isolation", ["process", "inproc"])
@pytest.mark.usual("inproc")
def test_nan_is_a_divergence(options, isolation):
    with pytest.raises(Diverged, match=r"t = 0\.101 s: the state is not finite"):
        run(options("nan", isolation=isolation))


@pytest.mark.parametrize("fault", ["discard", "error", "fatal"])
def test_results_are_reported_in_the_parent_process(options, fault):
    with pytest.raises(BackendDied, match=SAYS[fault].replace("its output", "it logged")) as caught:
        run(options(fault, isolation="inproc"))
    assert len(caught.value.run.rows) == 101


@pytest.mark.slow
def test_a_fault_in_the_first_step_is_not_waited_for_twice(options):
    chosen = options("hang")
    chosen["parameters"]["fault_time"] = 0.0
    chosen["step_timeout"] = PATIENCE
    began = monotonic()
    with pytest.raises(BackendDied, match="took more than 10 s"):
        run(chosen)
    assert monotonic() - began < 2 * PATIENCE


def command(options, *more):
    sets = [f"--set=backend_options.fmu.{key}={json.dumps(value)}" for key, value in options.items()]
    arguments = ["run", str(SCENARIO), "--backend=fmu", *sets, "--set=simulation.duration=0.2", "--no-report", *more]
    return subprocess.run([sys.executable, "-m", "cdpr", *arguments], capture_output=True, text=True, timeout=120)


@pytest.mark.slow
def test_printing_stays_off_stdout(options, tmp_path):
    done = command(options("print"), "--json", f"--out={tmp_path / 'run'}")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["samples"] == 201
    assert "an FMU that prints" not in done.stderr


@pytest.mark.slow
def test_exit_codes(options, tmp_path):
    done = command(options("segfault"), f"--out={tmp_path / 'run'}")
    assert done.returncode == ExitCode.BACKEND_DIED
    assert done.stderr.splitlines()[-1].startswith("stopped: t = 0.101 s: FMU '")
    assert "Traceback" not in done.stderr
    assert load_run(tmp_path / "run").rows.shape[0] == 101
