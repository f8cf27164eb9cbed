"""The controller `fmu`: a controller made elsewhere closes the loop like the same law of ours."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from fmu.controller import ENDS, write_controller

from cdpr import load_scenario, simulate
from cdpr.base.errors import ExitCode, FmuError, PlantEnded
from cdpr.fmu.read.archive import open_archive
from cdpr.simulation.build import build
from cdpr.testing import check_factory

pytest.importorskip("fmpy")

SCENARIO = ROOT / "scenarios/point_mass.yaml"
GAINS = {"kp": 50.0, "kd": 14.0}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmu")
    return {fmi: write_controller(folder / f"controller{fmi}.fmu", fmi) for fmi in (2, 3)}


def options(path, **more):
    sha256 = open_archive(path).sha256
    return {"type": "fmu", "file": str(path), "sha256": sha256, "parameters": GAINS, "isolation": "inproc"} | more


def run(controller, duration=1.0):
    return simulate(SCENARIO, overrides={"simulation.duration": duration, "controller": controller})


@pytest.mark.parametrize(("fmi", "isolation"), [(2, "inproc"), (3, "inproc"), (3, "process")])
def test_the_loop_is_that_of_the_same_law(files, fmi, isolation):
    ours = run({"type": "static", **GAINS})
    theirs = run(options(files[fmi], isolation=isolation))
    np.testing.assert_allclose(theirs.rows, ours.rows, rtol=1e-9, atol=1e-9)
    about = theirs.plugins["controller"]
    assert about["filled"] == ["mass", "gravity"]
    assert about["isolation"] == isolation
    assert [port["signal"] for port in about["mapping"]["outputs"]] == ["wrench"]


def test_an_fmu_may_put_out_commands(files):
    signals = {"outputs": {"wrench": "none", "command": ["wrench[1]", "wrench[2]", "wrench[3]"]}}
    parts = build(load_scenario(SCENARIO, overrides={"controller": options(files[3], signals=signals)}))
    assert parts.output == "command"
    assert parts.controller.output == "tension"  # in N, also for winches that take lengths
    out, state, desired = np.zeros(3), np.zeros(13), np.zeros(19)
    state[3] = desired[3] = 1.0
    desired[:3] = [1.0, 2.0, 3.0]
    parts.controller.control(0.0, state, desired, out)
    mass = parts.robot.platform.mass
    np.testing.assert_allclose(out, mass * (50.0 * desired[:3] + [0.0, 0.0, 9.81]), rtol=1e-14)
    parts.controller.close()
    parts.backend.close()


def test_it_may_end_the_run(files):
    with pytest.raises(PlantEnded, match=r"t = 0\.002 s: FMU '.*' requested the end") as caught:
        run(options(files[3], parameters={**GAINS, "mode": ENDS}))
    assert caught.value.exit_code == ExitCode.OK
    assert caught.value.run.status == "ended"
    assert len(caught.value.run.rows) == 2


def test_a_controller_that_the_robot_cannot_use_is_refused(files):
    with pytest.raises(FmuError, match=r"signals.outputs.command: expected 3 variables, got 2"):
        run(options(files[3], signals={"outputs": {"wrench": "none", "command": ["wrench[1]", "wrench[2]"]}}))


def test_the_kit_takes_it(files):
    from cdpr.plugins.registry import registry

    entry = registry().get("controller", "fmu")
    given = {key: value for key, value in options(files[3]).items() if key != "type"}
    chosen = entry.info.options.model_validate(given)
    only = {"output_is_complete", "inputs_stay_unchanged", "reset_forgets"}  # it takes no attitude
    results = check_factory("controller", entry.load(), properties={"output": "wrench"}, options=chosen, only=only)
    assert {result.outcome for result in results} <= {"passed"}, results
