"""Friction of pulleys against the equations of their docstring, by numpy, and its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, crossed_box, make_robot, random_state
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.cables import Pulley, exits_of, read_exits
from cdpr.cables.tables import line_table
from cdpr.native.bind import bind
from cdpr.plugins.registry import registry
from cdpr.scenario import load_scenario

SCENARIO = ROOT / "scenarios" / "cogiro_pulleys.yaml"
RADIUS, AXIS = 0.1, np.array([0.3, -0.2, 0.9])
POSES, M = 10_000, 8
EXACT = 2e-15  # of a tension: rounding of wrap angle, exponential and quotient
SHORT = {"simulation.duration": 0.1, "initial.velocity": [0.3, -0.2, 0.1]}
WINCH = {"drum_radius": 0.05, "inertia": 0.02}
STEEL = {"robot.cable.axial_stiffness": 1e6, "robot.cable.damping": 500.0, "robot.cable.linear_density": 0.1}
MODELS = {
    "ideal": {},
    "rigid": {"robot.cable.model": "rigid", "robot.winch": WINCH},
    "elastic": {"robot.cable.model": "elastic", "robot.winch": WINCH, **STEEL},
    "catenary": {"robot.cable.model": "catenary", "robot.winch": WINCH, **STEEL},
    "servo": {
        "robot.cable.model": "elastic",
        **STEEL,
        "robot.winch": {**WINCH, "type": "position", "velocity_gain": 2.0, "integral_gain": 10.0},
    },
}
MU = {"robot.cable.exit.friction": 0.2}


def wraps(anchors, axis, radius, tips):
    """Return wrap angles (k, m) and the unit vectors (k, m, 3) from the tips to the exits, from acos and atan2."""
    axis = axis / np.linalg.norm(axis)
    arm = tips - anchors
    z = arm @ axis
    away = arm - z[..., None] * axis
    x = np.linalg.norm(away, axis=-1)
    away = away / x[..., None]
    reach = np.hypot(x - radius, z)
    wrap = (np.arctan2(z, radius - x) - np.arccos(radius / reach)) % (2.0 * np.pi)
    leaving = anchors + radius * ((1.0 - np.cos(wrap))[..., None] * away + np.sin(wrap)[..., None] * axis)
    line = leaving - tips
    return wrap, line / np.linalg.norm(line, axis=-1)[..., None]


@pytest.fixture(scope="module")
def poses():
    """Robot, states (K, 13), wrap angles and rates (K, m), and directions (K, m, 3)."""
    rng = np.random.default_rng(0)
    robot = make_robot(crossed_box(rng, M))
    states = np.array([random_state(rng) for _ in range(POSES)])
    turned = Rotation.from_quat(states[:, 3:7], scalar_first=True).as_matrix()
    levers = np.einsum("kij,mj->kmi", turned, robot.anchors[:, 3:])
    wrap, u = wraps(robot.anchors[:, :3], AXIS, RADIUS, states[:, None, :3] + levers)
    velocity = states[:, None, 7:10] + np.cross(states[:, None, 10:], levers)
    return robot, states, wrap, -np.sum(u * velocity, axis=-1), u


def tensions(poses, **friction):
    """Return the tensions (K, m) at the platform for 1 N at the winches."""
    robot, states, *_ = poses
    cables = tuple(replace(each, exit=Pulley(radius=RADIUS, axis=tuple(AXIS), **friction)) for each in robot.cables)
    body, tension, found = np.zeros(13), np.zeros(M), np.zeros((len(states), M))
    lines = line_table(replace(robot, cables=cables))
    last = np.zeros(2 * M + 20)
    read = bind("exit_tensions", lines=lines, body=body, command=np.ones(M), tension=tension, last=last)
    for state, row in zip(states, found, strict=True):
        body[:] = state
        read()
        row[:] = tension
    return found


def test_capstan(poses):
    """T_high = T_low exp(mu beta) in 10 000 poses, wherever cables move; the high side is that of the motion."""
    _, _, wrap, rate, _ = poses
    platform = tensions(poses, friction=0.3, friction_speed=1e-4)
    moving = np.abs(rate) > 2e-3
    assert moving.mean() > 0.99
    low, high = np.where(rate > 0.0, 1.0, platform), np.where(rate > 0.0, platform, 1.0)
    error = np.abs(high / (low * np.exp(0.3 * wrap)) - 1.0)[moving]
    assert error.max() <= EXACT * 4.0
    assert ((high / low)[moving] >= 1.0).all()
    assert (rate[moving] > 0.0).mean() > 0.3
    assert (rate[moving] < 0.0).mean() > 0.3


def test_bearing(poses):
    """T_high - T_low = mu_b r_b / r |T_high e_1 - T_low e_2|."""
    _, _, _, rate, u = poses
    platform = tensions(poses, bearing_friction=0.4, bearing_radius=0.02, friction_speed=1e-4)
    high, low = np.maximum(platform, 1.0), np.minimum(platform, 1.0)
    towards_winch = -AXIS / np.linalg.norm(AXIS)
    load = np.linalg.norm(towards_winch - platform[..., None] * u, axis=-1)  # 1 N arrives, the platform's leaves
    moving = np.abs(rate) > 2e-3
    np.testing.assert_allclose((high - low)[moving], (0.4 * 0.02 / RADIUS * load)[moving], rtol=0, atol=1e-13)
    np.testing.assert_array_equal((platform > 1.0)[moving], (rate > 0.0)[moving])


def test_the_smaller_loss_counts_and_is_smooth_about_rest(poses):
    _, _, wrap, rate, _ = poses
    both = tensions(poses, friction=0.1, bearing_friction=0.4, bearing_radius=0.03, friction_speed=0.5)
    share = np.tanh(rate / 0.5)
    k = share * 0.4 * 0.03 / RADIUS
    losses = np.array([share * 0.1 * wrap, 2.0 * np.arcsinh(k * np.sin(0.5 * wrap) / np.sqrt(1.0 - k**2))])
    slips = np.abs(losses[0]) < np.abs(losses[1])
    np.testing.assert_allclose(both, np.exp(np.where(slips, *losses)), rtol=1e-14)
    assert 0.05 < slips.mean() < 0.95


@pytest.mark.parametrize("model", MODELS)
def test_runs_have_both_tensions(model):
    """The friction of the sampled state, by numpy, in runs of each winch and span."""
    speed = 0.05
    changes = {**SHORT, **MODELS[model], **MU, "robot.cable.exit.friction_speed": speed}
    run = cdpr.simulate(SCENARIO, backend="reference", overrides=changes)
    robot = load_scenario(SCENARIO, overrides=changes).robot
    turned = Rotation.from_quat(run.orientation, scalar_first=True).as_matrix()
    tips = run.position[:, None] + np.einsum("kij,mj->kmi", turned, robot.anchors[:, 3:])
    wrap, _ = wraps(robot.anchors[:, :3], np.array([0.0, 0.0, 1.0]), 0.1, tips)
    if model in ("ideal", "rigid"):
        paid_out = run.rate
    elif model == "servo":
        paid_out = run["unstretched_rate"]
    else:  # the drum starts with the cable
        paid_out = run.rate[:1]
    expected = np.exp(-np.tanh(paid_out / speed) * 0.2 * wrap[: len(paid_out)])
    winch, platform = run["winch_tension"][: len(paid_out)], run.cable_tension[: len(paid_out)]
    np.testing.assert_allclose(winch, expected * platform, rtol=1e-12)
    assert np.ptp(expected[platform > 0.0]) > 0.1
    if model == "ideal":
        np.testing.assert_array_equal(run["winch_tension"], run.tension)


def test_energy_balances():
    run = cdpr.simulate(SCENARIO, backend="reference", overrides={**SHORT, **MODELS["rigid"], **MU})
    gained = run.kinetic + run.potential - run.cable_work
    assert np.ptp(gained) < 1e-7 * np.abs(np.diff(run.kinetic)).sum()
    slow = {**SHORT, **MU, "simulation.physics_step": 1e-4}
    run = cdpr.simulate(SCENARIO, backend="reference", overrides=slow)
    gained = run.kinetic + run.potential - run.cable_work
    assert np.ptp(gained) < 1e-9 * np.abs(np.diff(run.kinetic)).sum()


@pytest.mark.parametrize("model", ["ideal", "elastic"])
def test_without_friction_no_bit_changes(model):
    plain = cdpr.simulate(SCENARIO, backend="reference", overrides={**SHORT, **MODELS[model]})
    zero = {"robot.cable.exit.friction": 0.0, "robot.cable.exit.friction_speed": 0.2}
    none = cdpr.simulate(SCENARIO, backend="reference", overrides={**SHORT, **MODELS[model], **zero})
    assert none.rows.tobytes() == plain.rows.tobytes()
    tiny = {"robot.cable.exit.friction": 1e-9}
    found = cdpr.simulate(SCENARIO, backend="reference", overrides={**SHORT, **MODELS[model], **tiny})
    np.testing.assert_allclose(found.position, plain.position, rtol=0, atol=1e-9)


def test_the_integrator_of_ideal_cables_agrees_with_that_of_winches():
    """Light drums become motors that hold tensions."""
    found = cdpr.simulate(SCENARIO, backend="reference", overrides={**SHORT, **MU})
    light = {**MODELS["rigid"], "robot.winch": {"drum_radius": 1.0, "inertia": 1e-9}}
    wound = cdpr.simulate(SCENARIO, backend="reference", overrides={**SHORT, **MU, **light})
    np.testing.assert_allclose(found.position, wound.position, rtol=0, atol=1e-8)
    np.testing.assert_allclose(found.cable_tension, wound.cable_tension, rtol=1e-6)
    np.testing.assert_allclose(found.cable_work, wound.cable_work, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("model", ["ideal", "elastic"])
def test_engines_batches_and_snapshots(model):
    changes = {**SHORT, **MODELS[model], "robot.cable.exit.friction": 0.1}
    scheme = {"backend_options.reference.scheme": "semi_implicit_euler"}
    euler = cdpr.simulate(SCENARIO, backend="reference", overrides={**changes, **scheme})
    mujoco = cdpr.simulate(SCENARIO, backend="mujoco", overrides=changes)
    np.testing.assert_allclose(mujoco.position, euler.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(mujoco["winch_tension"], euler["winch_tension"], rtol=1e-9)
    masses = np.linspace(85.0, 95.0, 8)
    columns = ("position", "winch_tension", "cable_work")
    found = cdpr.rollout(SCENARIO, 8, vary={"robot.platform.mass": masses}, overrides=changes, columns=columns)
    alone = cdpr.simulate(SCENARIO, backend="reference", overrides={**changes, "robot.platform.mass": masses[5]})
    for name in columns:
        assert found[name][5].tobytes() == alone[name].tobytes()
    simulation = cdpr.Simulation(SCENARIO, backend="reference", overrides=changes)
    for _ in range(20):
        simulation.step()
    kept, rows = simulation.snapshot(), []
    for _ in range(2):
        simulation.restore(kept)
        for _ in range(20):
            simulation.step()
        rows.append(simulation.row.tobytes())
    assert rows[0] == rows[1]


def test_exits_are_kept_in_headers():
    robot = load_scenario(SCENARIO, overrides=MU).robot
    assert exits_of(robot)[0] == {"type": "pulley", "radius": 0.1, "axis": [0.0, 0.0, 1.0], "friction": 0.2}
    assert read_exits(exits_of(robot))[3] == robot.cables[3].exit


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"bearing_friction": 0.1}, "expected both bearing_friction and bearing_radius, or neither, got one of them"),
        ({"bearing_friction": 2.0, "bearing_radius": 0.05}, r"below the radius of the pulley, 0.1 \(m\), got 0.1"),
        ({"friction_speed": 0.1}, "friction_speed needs friction or bearing_friction"),
        ({"friction": -0.1}, "friction"),
        ({"friction": 10.5}, "must be at most 10"),
    ],
)
def test_impossible_friction_is_an_error(keys, message):
    with pytest.raises(CdprError, match=message):
        Pulley(radius=0.1, **keys)
    with pytest.raises(ScenarioError, match=message):
        load_scenario(SCENARIO, overrides={f"robot.cable.exit.{key}": value for key, value in keys.items()})


def test_unsupported_uses_are_errors():
    broken = [{"type": "cable_break", "time": 0.05, "cable": "cable_1"}]
    with pytest.raises(ScenarioError, match=r"happens to ideal cables only, and robot.cable.exit has friction"):
        load_scenario(SCENARIO, overrides={**MU, "events": broken})
    with pytest.raises(PluginError, match=r"exit_friction"):
        cdpr.simulate(SCENARIO, backend="fmu", overrides={**SHORT, **MU})
    from cdpr.fmu.export import Actuator

    with pytest.raises(CdprError, match="pulleys with friction"):
        Actuator(load_scenario(SCENARIO, overrides={**MU, **MODELS["elastic"]}).robot, 1e-3).variables()


def test_legs_that_push_have_no_friction():
    """Its sign is that of cables under tension."""
    with pytest.raises(ScenarioError, match=r"exit\.friction: not supported for rigid legs"):
        load_scenario(SCENARIO, overrides={**MU, "robot.unilateral": False})
    robot = load_scenario(SCENARIO, overrides=MU).robot
    with pytest.raises(CdprError, match="friction on its exit: not supported for rigid legs"):
        line_table(replace(robot, unilateral=False))


@pytest.mark.slow
@pytest.mark.parametrize("model", ["ideal", "elastic"])
def test_an_exported_plant_with_winches_moves_as_reference_does(model, tmp_path):
    from fmu.cases import write
    from fmu.driver import Driver

    from cdpr.fmu.export import Plant

    scenario = load_scenario(SCENARIO, overrides={**SHORT, **MODELS[model], **MU})
    backend = registry().get("backend", "reference").make(scenario.robot, scenario.gravity, 1e-3, None)
    backend.reset(scenario.initial.state())
    backend.command[:] = command = 350.0 + 40.0 * np.sin(np.arange(8.0))
    plant = Plant(scenario.robot, scenario.gravity, 1e-3, scenario.initial.state(), winches=True)
    with Driver(write(plant, 3, tmp_path)) as driver:
        driver.set("command", command)
        for k in range(100):
            driver.step(1e-3 * k, 1e-3)
            backend.step(1)
            assert np.abs(driver.state() - backend.state).max() < 1e-8  # other variables of the integrator
        backend.read_tension(command)
        np.testing.assert_allclose(driver.get("cable_tension"), command, rtol=1e-9)
