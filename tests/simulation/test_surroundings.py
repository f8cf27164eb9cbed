"""Backends in the environment of a scenario: contact of the platform with obstacles."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import GRAVITY, ROOT
from plants import installed, plant

import cdpr
from cdpr.base.errors import PluginError, ScenarioError
from cdpr.model import Box
from cdpr.model.shapes import Obstacle
from cdpr.plugins import Environment
from cdpr.simulation.build import faults
from cdpr.simulation.needs import omitted, require
from cdpr.testing import check_factory, samples

CAROCA = ROOT / "scenarios" / "caroca.yaml"
BACKENDS = installed("reference", "mujoco", "bullet", "dart", "fmu")
mujoco = pytest.mark.skipif("mujoco" not in BACKENDS, reason="mujoco is not installed")

# The platform at the height of 1.2 m is pressed on a table 3 mm below it.
TABLE = {"name": "table", "box": [4.0, 4.0, 0.2], "position": [0.0, 0.0, 0.997]}
PRESSED = {
    "simulation.duration": 0.4,
    "trajectory": {"type": "hold"},
    "robot.platform.shape": {"box": [0.4, 0.4, 0.2]},
    "world.obstacles": [TABLE],
    "events": [{"type": "wrench", "time": 0.05, "force": [0.0, 0.0, -3000.0]}],
}
CONTACT = PRESSED | {"world.contact": True}


def run(overrides, **options):
    return cdpr.simulate(CAROCA, overrides=overrides, **options)


@mujoco
def test_the_platform_touches_an_obstacle():
    from touching import Touching

    through, stopped = run(PRESSED, backend="mujoco"), run(CONTACT, backend=Touching)
    assert through.position[:, 2].min() < 1.18
    assert stopped.position[:, 2].min() > 1.19
    assert stopped.position[-1, 2] == pytest.approx(1.197, abs=5e-4)
    assert stopped.interpreted == ()
    free = stopped.time <= 0.05
    assert not stopped["touch"][free].any()
    np.testing.assert_array_equal(stopped.position[free], through.position[free])
    assert stopped["touch"][-1, 2] > 500.0
    np.testing.assert_allclose(stopped["touch"][-1, :2], 0.0, atol=1e-3)


@mujoco
def test_without_contact_obstacles_have_no_effect():
    from touching import Touching

    expected = run(PRESSED | {"world.obstacles": []}, backend="mujoco")
    for kind in ("mujoco", Touching):
        np.testing.assert_array_equal(run(PRESSED, backend=kind).position, expected.position)


@mujoco
def test_snapshots_in_contact():
    from touching import Touching

    with cdpr.Simulation(CAROCA, backend=Touching, overrides=CONTACT) as simulation:
        simulation.step(200)
        before = simulation.snapshot()
        simulation.step(100)
        end = simulation.row
        assert end[-1] > 0.0
        simulation.restore(before)
        simulation.step(100)
        np.testing.assert_array_equal(simulation.row, end)


@mujoco
def test_the_kit_checks_surroundings():
    from touching import Touching

    ids = ["obstacles_stop_the_platform", "distant_obstacles_have_no_effect", "operations_make_a_step"]
    results = check_factory("backend", Touching, properties=Touching.properties, only=ids)
    assert [(each.outcome, each.detail) for each in results] == [("passed", "")] * 3
    results = check_factory("backend", Touching, only=ids[1:])
    assert {each.outcome for each in results} == {"n/a", "passed"}


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_backend_without_obstacles_rejects_contact(backend):
    scenario = cdpr.load_scenario(CAROCA, backend=backend, overrides=CONTACT)
    (found,) = [str(each.error) for each in faults(scenario) if each.path == ("world", "contact")]
    assert f"world.contact: backend '{backend}', with its options, does not support surroundings: obstacles" in found
    with pytest.raises(PluginError, match="does not support surroundings: obstacles"):
        run(CONTACT, backend=backend)


def test_contact_needs_a_shape():
    with pytest.raises(ScenarioError, match=r"world.contact: expected a platform with a shape"):
        cdpr.load_scenario(CAROCA, overrides={"world.contact": True, "robot.platform.shape": None})


def test_exports_reject_or_report_contact():
    scenario = cdpr.load_scenario(CAROCA, overrides=CONTACT)
    with pytest.raises(ScenarioError, match=r"world.contact: not supported by an exported FMU without controller"):
        require(scenario, "plant_fmu")
    assert "world.contact: not exported" in omitted(scenario, "mjcf")


def test_a_backend_without_the_method_rejects_an_environment():
    table = Obstacle("table", Box((1.0, 1.0, 1.0)), np.zeros(3), np.eye(4)[0])
    with pytest.raises(PluginError, match="does not support an environment"):
        plant("reference", samples.free(), gravity=GRAVITY).surround(Environment((table,)))
