"""Anchors that a part of the loop moves: the observed sample, its energy, the nominal robot, snapshots and rollouts."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from moving_anchors import Broken, Carriage, Spoiling
from plants import installed
from pydantic import Field
from restarts import assert_restarts_give

import cdpr
from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.base.fields import Section
from cdpr.base.needs import of_moving_anchors
from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.scenario.needs import lacking
from cdpr.simulation import loop_parts
from cdpr.simulation.build import faults
from cdpr.simulation.loop_part import LoopPart
from cdpr.simulation.needs import require

CAROCA, WINCH, BELIEVED = (str(ROOT / "scenarios" / f"{name}.yaml") for name in ("caroca", "winch", "believed"))
SHORT = {"simulation.duration": 0.05}
MOTION = (0.02, 0.01, -0.03), (0.1, 0.3, -0.2)  # m/s, m/s^2
BACKENDS = ["reference", *installed("mujoco", "bullet", "dart")]


@pytest.fixture
def run(monkeypatch):
    """Return a function that runs a scenario with these parts, one of each kind for each run."""

    def simulate(scenario, *parts, **overrides):
        use(monkeypatch, *parts)
        return cdpr.simulate(scenario, overrides={**SHORT, **overrides})

    return simulate


def use(monkeypatch, *parts):
    made = [lambda scenario, make=make: make() for make in parts]
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", made)


def carriage():
    return Carriage(*MOTION)


def displacement(time):
    """(k, 3) of the frame at times (k,)."""
    velocity, acceleration = np.array(MOTION)
    return np.outer(time, velocity) + 0.5 * np.outer(time**2, acceleration)


@pytest.mark.parametrize("scenario", [CAROCA, WINCH])
def test_a_part_that_does_not_move_the_anchors_changes_nothing(run, scenario):
    assert np.array_equal(run(scenario).rows, run(scenario, Carriage).rows, equal_nan=True)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scenario", [CAROCA, WINCH])
def test_observed_lengths_and_rates_are_those_of_the_moved_anchors(run, scenario, backend):
    found = run(scenario, carriage, **{"simulation.backend": backend})
    robot, velocity = cdpr.load_scenario(scenario).robot, np.array(MOTION[0]) + np.outer(found.time, MOTION[1])
    for k in (0, 20, len(found.time) - 1):
        R = cdpr.model.rotations.matrix(found.orientation[k])
        arm = robot.anchors[:, 3:] @ R.T
        chord = robot.anchors[:, :3] + displacement(found.time)[k] - found.position[k] - arm
        length = np.linalg.norm(chord, axis=1)
        relative = velocity[k] - found.velocity[k] - np.cross(found.angular_velocity[k], arm)
        assert np.allclose(found.length[k], length, rtol=0.0, atol=1e-12)
        assert np.allclose(found.rate[k], np.sum(chord * relative, axis=1) / length, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("scenario", [CAROCA, WINCH])
def test_the_energy_balances_with_the_work_of_the_anchors(run, scenario):
    moved = run(scenario, carriage).summary()["energy_J"]
    shortening = run(scenario, lambda: Carriage((0.0, 0.0, 0.5))).summary()["energy_J"]
    assert moved["balanced"]
    assert shortening["balanced"]
    assert shortening["residual_max"] < 1e-3 * shortening["turned_over"]


def test_the_controller_uses_the_anchors_of_the_sample(run):
    found, robot = run(CAROCA, carriage), cdpr.load_scenario(CAROCA).robot
    k = len(found.time) - 1
    pose = np.array([*(found.position[k] - displacement(found.time)[k]), *found.orientation[k], *np.zeros(6)])
    assert np.allclose(wrench_matrix(robot, pose) @ found.tension[k], found.wrench[k], rtol=0.0, atol=1e-6)
    rest = np.array([*found.position[k], *found.orientation[k], *np.zeros(6)])
    assert np.abs(wrench_matrix(robot, rest) @ found.tension[k] - found.wrench[k]).max() > 0.1


def test_anchors_of_the_nominal_robot_move_with_the_true_ones(run):
    found, nominal = run(BELIEVED, carriage), cdpr.load_scenario(BELIEVED).nominal
    k = len(found.time) - 1
    pose = np.array([*(found.position[k] - displacement(found.time)[k]), *found.orientation[k], *np.zeros(6)])
    assert np.allclose(wrench_matrix(nominal, pose) @ found.tension[k], found.wrench[k], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("scenario", [CAROCA, WINCH])
def test_snapshots_and_resets(monkeypatch, run, scenario):
    whole = run(scenario, carriage).rows.tobytes()
    assert_restarts_give(whole, scenario, SHORT)


def test_rollouts_have_the_bits_of_single_runs(run):
    masses = [150.0, 160.0, 170.0]
    runs = [run(CAROCA, carriage, **{"robot.platform.mass": mass}) for mass in masses]
    batch = cdpr.rollout(CAROCA, 3, vary={"robot.platform.mass": masses}, overrides=SHORT, columns=["position", "rate"])
    for i, single in enumerate(runs):
        assert np.array_equal(batch["position"][i], single.position)
        assert np.array_equal(batch["rate"][i], single.rate)


@pytest.mark.parametrize(("after", "samples"), [(0.02, 21), (-1.0, 0)])
@pytest.mark.parametrize(("of", "bad"), [("position", np.nan), ("velocity", np.inf), ("acceleration", -np.inf)])
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_motion_that_is_not_finite_is_named(run, backend, of, bad, after, samples):
    spoilt = type("Spoilt", (Spoiling,), {"of": of, "bad": bad, "after": after})
    expected = f"by 'carriage' wrote {bad} into the {of} of cable 'cable_3'; expected finite numbers"
    with pytest.raises(PluginError, match=expected) as told:
        run(CAROCA, spoilt, **{"simulation.backend": backend})
    assert len(told.value.run.rows) == samples


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_motion_that_fails_ends_the_run(run, backend):
    with pytest.raises(PluginError, match=r"the motion of the anchors by 'carriage' returned 7; expected 0"):
        run(CAROCA, Broken, **{"simulation.backend": backend})


def test_unsupported_combinations(run):
    with pytest.raises(CdprError, match="expected one part that moves them, got 'carriage', 'trolley'"):
        run(CAROCA, carriage, type("Trolley", (Carriage,), {"name": "trolley"}))
    with pytest.raises(CdprError, match="expected cables that leave from points, got exit pulley"):
        run(str(ROOT / "scenarios" / "cogiro_pulleys.yaml"), carriage)
    with pytest.raises(PluginError, match="part 'carriage' declares moves_anchors"):
        run(CAROCA, type("Lazy", (Carriage,), {"anchor_motion": Carriage.__mro__[1].anchor_motion}))


NATIVE = {"simulation.backend": "mujoco", "backend_options.mujoco.cables": "native"}


@pytest.mark.parametrize(
    ("changes", "who"),
    [
        ({"controller": {"type": "cable_length"}}, "controller 'cable_length'"),
        ({"controller": {"type": "remote", "program": "pyproject.toml"}}, "controller 'remote'"),
        ({"simulation.backend": "fmu"}, "backend 'fmu'"),
        (NATIVE, "backend 'mujoco'"),
    ],
)
def test_a_plugin_without_support_is_rejected_without_a_section(monkeypatch, changes, who):
    use(monkeypatch, carriage)
    scenario = cdpr.load_scenario(CAROCA, overrides={**SHORT, **changes})
    (fault,) = faults(scenario)
    assert str(fault.error).startswith(
        f"part of the loop 'carriage': {who}, with its options, does not support features: moving"
    )
    use(monkeypatch, LoopPart)
    assert list(faults(scenario)) == []


def test_a_controller_that_declares_nothing_is_rejected(monkeypatch):
    class Blind(cdpr.plugins.Controller):
        def control(self, time, state, desired, out):
            out[:] = 0.0

    use(monkeypatch, carriage)
    with pytest.raises(PluginError, match="controller 'Blind', with its options, does not support features: moving"):
        cdpr.simulate("caroca", controller=Blind, overrides=SHORT)


def test_faults_of_parts_that_move_the_anchors_are_found_without_a_run(monkeypatch):
    def found(scenario, *parts, **overrides):
        use(monkeypatch, *parts)
        return [str(fault.error) for fault in faults(cdpr.load_scenario(scenario, overrides=overrides))]

    (several,) = found(CAROCA, carriage, type("Trolley", (Carriage,), {"name": "trolley"}))
    (pulleys,) = found(str(ROOT / "scenarios" / "cogiro_pulleys.yaml"), carriage)
    (actuators,) = found(WINCH, carriage, actuators={})
    assert several == "anchors that move: expected one part that moves them, got 'carriage', 'trolley'"
    assert "expected cables that leave from points, got exit pulley" in pulleys
    assert actuators == "actuators: do not support anchors that move, by part of the loop 'carriage'"


def test_a_section_and_its_part_are_reported_once(monkeypatch):
    use(monkeypatch, carriage)
    rows = [(("frame",), of_moving_anchors(), None)]
    monkeypatch.setattr("cdpr.scenario.needs.in_use", lambda scenario: rows)
    scenario = cdpr.load_scenario(CAROCA, overrides={"controller": {"type": "cable_length"}})
    (fault,) = faults(scenario)
    assert fault.path == ("frame",)


def test_needs_of_a_section_that_moves_the_anchors(monkeypatch):
    scenario = cdpr.load_scenario(CAROCA)

    class Frame(Section):
        speed: float = Field(description="of the frame")
        needs = of_moving_anchors()

    for module in ("scenario", "simulation"):
        monkeypatch.setattr(f"cdpr.{module}.needs.in_use", lambda scenario: [(("frame",), Frame.needs, None)])
    for use in ("plant_fmu", "controller_fmu", "bare_controller_fmu", "native", "mjcf", "sdf", "urdf"):
        with pytest.raises(ScenarioError, match="its cables leave from anchors at rest"):
            require(scenario, use)
    for use in ("rollout", "live", "compare"):
        require(scenario, use)
    features = {"features": ("moving_anchors",)}
    for role in ("backend", "controller"):
        assert list(lacking(scenario, role, {})) == [(("frame",), "features: moving_anchors")]
        assert list(lacking(scenario, role, features)) == []


def test_lengths_of_cables_that_sag_follow_the_anchors(run):
    """A frame at constant velocity, which the platform shares, changes no commanded length."""
    velocity = np.array([0.4, -0.3, 0.2])
    winch = {"type": "position"}
    start = {"initial.velocity": velocity.tolist(), "trajectory": {"type": "hold"}, "robot.winch": winch}
    controller = {"controller": {"type": "computed_torque", "kp": 0.0, "kd": 0.0}, "simulation.duration": 0.2}
    resting = run("sagging", **(start | controller | {"initial.velocity": [0.0, 0.0, 0.0]}))
    carried = run("sagging", lambda: Carriage(velocity), **start, **controller)
    np.testing.assert_allclose(carried.winch_command, resting.winch_command, rtol=1e-9)
    moved = np.outer(carried.time, velocity)
    np.testing.assert_allclose(carried.position - moved, resting.position, atol=1e-9)
