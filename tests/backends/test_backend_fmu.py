"""The backend `fmu`: the robot as exported against `reference`, and what its checks at the start find."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from conftest import ROOT

from cdpr import load_scenario, simulate
from cdpr.base.errors import BackendDied, FmuError, PluginError, ScenarioError
from cdpr.fmu.export import Plant, fmu_bytes
from cdpr.fmu.read.archive import open_archive
from cdpr.mechanics import kinematics
from cdpr.plugins.registry import registry
from cdpr.simulation.build import build
from cdpr.testing import check_factory

pytest.importorskip("fmpy")

SCENARIO = ROOT / "scenarios/caroca_fmu.yaml"
STATE = kinematics.make_state([0.1, -0.2, 1.3], [0.8, 0.2, -0.4, 0.4])
ORDER = [3, 1, 2, 8, 7, 6, 4, 5]


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return caroca as a file, in FMI 2 and 3, as another tool would export it: initial state at the origin."""
    scenario, folder = load_scenario(SCENARIO), tmp_path_factory.mktemp("fmu")
    plant = Plant(scenario.robot, scenario.gravity, 1e-3, kinematics.make_state(np.zeros(3)))
    made = {}
    for fmi in (2, 3):
        path = folder / f"caroca{fmi}.fmu"
        path.write_bytes(fmu_bytes(plant, fmi))  # write_fmu would also change the user's list of trusted FMUs
        made[fmi] = path, open_archive(path).sha256
    return made


def built(options, **overrides):
    changes = {"initial": {"position": [0.1, -0.2, 1.3], "orientation": {"quaternion": [0.8, 0.2, -0.4, 0.4]}}}
    return build(load_scenario(SCENARIO, overrides={**changes, **overrides, "backend_options.fmu": options})).backend


def file_of(exported, fmi=3, **options):
    path, sha256 = exported[fmi]
    return {"file": str(path), "sha256": sha256, "isolation": "inproc", **options}


def ride(backend):
    backend.command[:] = np.linspace(300.0, 600.0, 8)
    backend.external[:] = [10.0, -20.0, 30.0, 1.0, 2.0, -3.0]
    for _ in range(50):
        backend.step(2)
    end = backend.state.copy()
    backend.close()
    return end


def reference():
    scenario = load_scenario(
        SCENARIO, backend="reference", overrides={"initial": {"position": [0.1, -0.2, 1.3]}, "simulation.duration": 1.0}
    )
    backend = build(scenario).backend
    backend.reset(STATE)
    return ride(backend)


@pytest.mark.parametrize("isolation", ["inproc", "process"])
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.usual("3-*", "2-inproc")
def test_an_export_is_the_reference_to_the_bit(fmi, isolation):
    np.testing.assert_array_equal(ride(built({"export": {"fmi": fmi}, "isolation": isolation})), reference())


def test_a_closed_loop_is_that_of_the_reference():
    ours, theirs = simulate(SCENARIO), simulate(SCENARIO, backend="reference")
    assert len(ours.rows) == 4001
    assert np.abs(ours["position"] - theirs["position"]).max() <= 1e-9  # m
    assert np.abs(ours.rows - theirs.rows).max() <= 1e-9 * np.abs(theirs.rows).max()


def test_without_options_the_robot_is_exported(tmp_path):
    run = simulate(ROOT / "scenarios/planar.yaml", backend="fmu", overrides={"simulation.duration": 0.1})
    assert run.plugins["backend"]["isolation"] == "inproc"
    assert {port["signal"] for port in run.plugins["backend"]["mapping"]["inputs"]} == {
        "cable_tension",
        "external_wrench",
    }


@pytest.mark.parametrize(("fmi", "step"), [(2, 0.001), (3, 0.0005)])
@pytest.mark.usual("3-*")
def test_a_file_is_found_beside_the_scenario_and_runs_apart(exported, tmp_path, fmi, step):
    path, sha256 = exported[fmi]
    shutil.copy(path, tmp_path / "plant.fmu")
    (tmp_path / "robot.yaml").write_text((ROOT / "scenarios/robots/caroca.yaml").read_text())
    text = SCENARIO.read_text().replace("robots/caroca.yaml", "robot.yaml")
    (tmp_path / "scenario.yaml").write_text(
        text.replace("export: {fmi: 3}", f"file: plant.fmu\n    sha256: {sha256}\n    step: {step}")
    )
    run = simulate(tmp_path / "scenario.yaml", overrides={"simulation.duration": 0.05})
    about = run.plugins["backend"]
    assert (about["isolation"], about["step"], about["sha256"]) == ("process", step, sha256)
    assert "mass" in about["filled"]


def test_cables_in_another_order_are_the_same_plant(exported):
    options = file_of(exported, signals={"cable_order": ORDER})
    np.testing.assert_allclose(ride(built(options)), reference(), rtol=0.0, atol=1e-11)


WRONG = [
    (
        {"signals": {"outputs": {"quaternion": {"variable": "quaternion", "order": "xyzw"}}}},
        "quaternion .* the scenario",
    ),
    (
        {"signals": {"outputs": {"position": ["position[2]", "position[1]", "position[3]"]}}},
        "starts with the position .* check the mapping",
    ),
    ({"signals": {"outputs": {"position": {"variable": "position", "unit": "mm"}}}}, "starts with the position"),
    ({"signals": {"cable_order": ORDER}, "from_robot": False}, "cables are .* check signals.cable_order"),
    (
        {"signals": {"cable_order": ORDER, "outputs": {"cable_length": "none"}}, "from_robot": False},
        "does not pull along cable .*, but as .* would .*check signals.cable_order",
    ),
    (
        {"signals": {"inputs": {"cable_tension": {"variable": "cable_tension", "factor": -1.0}}}},
        r"does not pull along cable '.*' when that is tensioned \(cosine -1\.00\)",
    ),
    (
        {"signals": {"inputs": {"cable_tension": {"variable": "cable_tension", "factor": 0.001}}}},
        "pulls 1e\\+03 times as much as its cables are tensioned",
    ),
    ({"parameters": {"initial_position": [0.0, 0.0, 2.0]}}, r"starts with the position \[0, 0, 2\]"),
    ({"parameters": {"masss": 3.0}}, "no variable 'masss'"),
    ({"parameters": {"mass": "heavy"}}, "expected a value of the kind Float64, got 'heavy'"),
    ({"parameters": {"mass": -1.0}}, "Error; it logged: Error: .*mass"),
]


@pytest.mark.parametrize(("options", "text"), WRONG)
def test_errors_are_found_at_the_start(exported, options, text):
    with pytest.raises((FmuError, BackendDied), match=text) as caught:
        built(file_of(exported, **options))
    assert "\n" not in str(caught.value)


def test_a_weak_pull_is_reported(exported):
    signals = {"inputs": {"cable_tension": {"variable": "cable_tension", "unit": "kN"}}}
    with pytest.warns(UserWarning, match=r"pulls 0\.001 times as much as its cables are tensioned, in the first step"):
        built(file_of(exported, signals=signals)).close()


def test_foreign_code_requires_trust(exported):
    options = file_of(exported)
    del options["sha256"]
    with pytest.raises(FmuError, match="is not trusted"):
        built(options)


def test_a_step_divides_the_physics_step(exported):
    with pytest.raises(FmuError, match=r"step: must be physics_step, 0\.001 s, divided by an integer, got 0\.0003"):
        built(file_of(exported, step=0.0003))


def test_a_wrench_that_the_fmu_cannot_take_is_refused(exported):
    backend = built(file_of(exported, signals={"inputs": {"external_wrench": "none"}}))
    backend.step(1)
    backend.external[2] = 1.0
    with pytest.raises(PluginError, match="no input for an external wrench"):
        backend.step(1)
    backend.close()


def test_file_and_export_exclude_each_other():
    with pytest.raises(ScenarioError, match="file and export exclude each other"):
        load_scenario(SCENARIO, overrides={"backend_options.fmu": {"file": "x.fmu", "export": {}}})


def test_snapshots_that_are_gone_are_freed(exported):
    backend = built(file_of(exported))
    for _ in range(5):
        snapshot = backend.snapshot()
    assert len(backend.fmu.instance._kept) <= 2
    backend.step(3)
    there = backend.state.copy()
    backend.restore(snapshot)
    backend.step(3)
    np.testing.assert_array_equal(backend.state, there)
    backend.close()


@pytest.mark.slow
def test_a_process_of_its_own_passes_the_kit():
    entry = registry().get("backend", "fmu")
    few = {"reset_forgets", "steps_add_up", "snapshot_restores", "clock_counts_steps", "keeps_quiet"}
    options = entry.info.options(isolation="process")
    results = check_factory("backend", entry.load(), properties=entry.info.properties, options=options, only=few)
    assert {result.outcome for result in results} == {"passed"}, results
