"""Anchors that move, in each backend: the same relative motion in a frame that moves uniformly or accelerates."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import GRAVITY
from moving_anchors import moving
from plants import installed, plant

import cdpr
from cdpr.base.errors import CdprError, PluginError
from cdpr.cables import with_model
from cdpr.mechanics.anchors import Anchors
from cdpr.plugins.registry import registry

DURATION = 0.08  # s
NONE = np.zeros(3)
VELOCITY, ACCELERATION = np.array([0.5, -0.3, 0.2]), np.array([1.0, 2.0, -0.5])  # m/s, m/s^2

# Positions of metres, and velocities of a metre per second, after a hundred steps.
ROUND_OFF = 1e-12

# Tensions of kilonewtons of cables with 1e5 N/m and more, whose lengths of metres have errors of round-off.
ROUND_OFF_TENSION = 1e-8  # N

ENGINES = installed("mujoco", "bullet", "dart")


def robot_of(name, model=None):
    robot = cdpr.load_robot(name)
    return robot if model is None else with_model(robot, model)


def motion(name, robot, step, *, velocity=NONE, acceleration=NONE, moves=True, **options):
    """State (13,) after a while, relative to the frame, and tensions (m,); without anchors that move, in a frame at
    rest where the acceleration is part of gravity."""
    gravity = np.array(GRAVITY) - (NONE if moves else acceleration)
    backend = plant(name, robot, gravity=gravity, step=step, **options)
    start = np.array([*robot.home, *np.zeros(6)])
    if moves:
        backend.follow(moving(robot, velocity, acceleration))
        start[7:10] += velocity
    backend.reset(start)
    backend.command[:] = robot.tension_min + np.linspace(0.05, 0.1, robot.m) * (robot.tension_max - robot.tension_min)
    for _ in range(round(DURATION / step) // 4):
        backend.step(4)
    state, tension = backend.state.copy(), np.zeros(robot.m)
    backend.read_tension(tension)
    backend.close()
    if moves:
        state[:3] -= DURATION * velocity + 0.5 * DURATION**2 * acceleration
        state[7:10] -= velocity + DURATION * acceleration
    return state, tension


def held(robot, vector):
    """The part of a vector (3,) along the free directions of a robot: its guide does not move with the frame."""
    return np.where([axis in robot.dof for axis in "xyz"], vector, 0.0)


@pytest.mark.parametrize("name", ["reference", *ENGINES])
@pytest.mark.parametrize(
    ("robot", "model"), [("caroca", None), ("caroca_winches", "rigid"), ("caroca_winches", "elastic")]
)
def test_uniform_motion_changes_nothing(name, robot, model):
    robot = robot_of(robot, model)
    rest, tension = motion(name, robot, 1e-3, moves=False)
    state, same = motion(name, robot, 1e-3, velocity=VELOCITY)
    assert np.abs(state - rest).max() < ROUND_OFF
    assert np.abs(same - tension).max() < ROUND_OFF_TENSION
    assert np.abs(rest[:3] - robot.home[:3]).max() > 1e-3


@pytest.mark.parametrize("scheme", ["rk4", "semi_implicit_euler"])
@pytest.mark.parametrize("robot", ["planar", "spherical", "carriage"])
def test_uniform_motion_of_guided_platforms(robot, scheme):
    robot = robot_of(robot)
    velocity = held(robot, VELOCITY)
    rest, _ = motion("reference", robot, 1e-3, moves=False, scheme=scheme)
    state, _ = motion("reference", robot, 1e-3, velocity=velocity, scheme=scheme)
    assert np.abs(state - rest).max() < ROUND_OFF


def differences(name, robot, steps, **options):
    """Distances from the motion under apparent gravity, for these steps."""
    found = []
    for step in steps:
        rest, _ = motion(name, robot, step, acceleration=ACCELERATION, moves=False, **options)
        state, _ = motion(name, robot, step, velocity=VELOCITY, acceleration=ACCELERATION, **options)
        found.append(np.abs(state - rest).max())
    return found


@pytest.mark.parametrize(
    ("robot", "model", "steps"),
    [
        ("caroca", None, (10e-3, 5e-3)),
        ("caroca_winches", "rigid", (5e-3, 2.5e-3)),
        ("caroca_winches", "elastic", (5e-4, 2.5e-4)),  # the step has to follow the vibration of the cables
    ],
)
def test_an_accelerated_frame_keeps_the_fourth_order(robot, model, steps):
    coarse, fine = differences("reference", robot_of(robot, model), steps)
    assert 13.0 < coarse / fine < 19.0
    assert coarse < 1e-7


@pytest.mark.parametrize("name", [*ENGINES, "reference"])
def test_engines_use_the_anchors_at_the_start_of_the_step(name):
    options = {"scheme": "semi_implicit_euler"} if name == "reference" else {}
    coarse, fine = differences(name, robot_of("caroca"), (4e-3, 2e-3), **options)
    # Velocity and place of the frame: v and h (v + h a) + ... exceed v t and a t^2 / 2 by h a t / 2.
    assert coarse == pytest.approx(0.5 * 4e-3 * DURATION * np.abs(ACCELERATION).max(), rel=0.02)
    assert coarse / fine == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("name", ["reference", *ENGINES])
def test_snapshots_contain_the_time_of_the_anchors(name):
    robot = robot_of("caroca_winches", "elastic")
    backend = plant(name, robot)
    backend.follow(moving(robot, VELOCITY, ACCELERATION))
    backend.reset(np.array([*robot.home, *VELOCITY, *NONE]))
    backend.command[:] = 0.1 * robot.tension_max
    backend.step(5)
    saved = backend.snapshot()
    ends = []
    for _ in range(2):
        backend.step(5)
        ends.append(backend.state.tobytes())
        backend.restore(saved)
    assert ends[0] == ends[1]
    backend.reset(np.array([*robot.home, *VELOCITY, *NONE]))
    backend.step(10)
    assert backend.state.tobytes() == ends[0]
    backend.close()


def test_backends_and_options_without_support():
    robot = robot_of("caroca")
    anchors = Anchors(robot)
    for name, cables in [(name, cables) for name in ENGINES for cables in ("ups", "native")]:
        if cables == "native" and name != "mujoco":
            continue
        backend = plant(name, robot, cables=cables)
        assert registry().get("backend", name).properties(backend.options)["features"] == ()
        with pytest.raises(PluginError, match="not support anchors that move"):
            backend.follow(anchors)


def test_only_points_and_compiled_operations():
    with pytest.raises(CdprError, match="expected cables that leave from points, got exit pulley of cable"):
        Anchors(cdpr.load_robot("cogiro_pulleys"))
    with pytest.raises(CdprError, match="expected a compiled operation"):
        Anchors(robot_of("caroca")).move(lambda time: 0)
