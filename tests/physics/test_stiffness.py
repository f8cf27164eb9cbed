"""Stiffness against finite differences of what cables exert, frequencies against vibrations that are simulated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import GRAVITY, ROOT
from plants import plant

from cdpr import load_robot
from cdpr.analysis.distribution import distribute
from cdpr.analysis.workspace import answers
from cdpr.analysis.workspace.question import Question
from cdpr.cables import with_model
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import lengths, make_state, wrench_matrix
from cdpr.mechanics.properties import home_pose
from cdpr.mechanics.stiffness import inertia, stiffness
from cdpr.model import rotations

NAMES = sorted(file.stem for file in (ROOT / "scenarios" / "robots").glob("*.yaml"))
STIFF = 1e5  # N
STEP = 1e-5  # m and rad: differences are off by about its square, and by round-off over it
FROM_DIFFERENCES = 1e-8  # of the largest entry; measured 2e-10
SYMMETRIC = 1e-10  # takes some minutes, where all is in balance
FREQUENCY = 1e-3  # of one that is simulated for some periods at 1 ms; measured 1e-7


def robot_of(name):
    return load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


def turned(pose, d):
    """A pose (7,) moved by (6,): a shift, and a turn about the world's axes."""
    size = np.linalg.norm(d[3:])
    turn = rotations.from_axis_angle(d[3:] / size, size) if size else np.array([1.0, 0.0, 0.0, 0.0])
    return make_state(pose[:3] + d[:3], rotations.multiply(turn, pose[3:]))


@pytest.mark.parametrize("name", NAMES)
def test_stiffness_is_what_differences_show(name):
    """With unstretched lengths that stay, so that tensions change, too."""
    robot = with_model(robot_of(name), "elastic")  # cables that sag: tests/mechanics/test_sagging_equilibrium.py
    pose = home_pose(robot)[0]
    rng = np.random.default_rng(0)
    tension = rng.uniform(100.0, 1000.0, robot.m)
    K, W = stiffness(robot, pose[None], tension[None], axial_stiffness=STIFF, gravity=GRAVITY)
    state = make_state(pose[:3], pose[3:])
    assert W[0] == pytest.approx(wrench_matrix(robot, state))
    unwound = lengths(robot, state) / (1.0 + tension / STIFF)

    def acting(d):
        at = turned(pose, d)
        pulled = STIFF * (lengths(robot, at) - unwound) / unwound
        return wrench_matrix(robot, at) @ pulled - required_wrench(robot, at, GRAVITY)

    differences = [(acting(-STEP * e) - acting(STEP * e)) / (2.0 * STEP) for e in np.eye(6)]
    assert np.abs(np.transpose(differences) - K[0]).max() <= FROM_DIFFERENCES * np.abs(K[0]).max()


@pytest.mark.parametrize("name", ["caroca", "cogiro", "cogiro_pulleys", "ipanema_1", "off_centre", "planar", "twelve"])
@pytest.mark.usual("caroca", "cogiro_pulleys", "planar")
def test_stiffness_is_symmetric_where_all_is_in_balance(name):
    robot = robot_of(name)
    pose = home_pose(robot)[0]
    held = distribute(robot, pose[None], gravity=GRAVITY)
    assert held.feasible.all()
    K, _ = stiffness(robot, pose[None], held.tension, axial_stiffness=STIFF, gravity=GRAVITY)
    free = K[0][np.ix_(robot.rows, robot.rows)]
    assert np.abs(free - free.T).max() <= SYMMETRIC * np.abs(free).max()


def test_cables_without_stiffness_of_their_own_give_that_of_their_tensions_alone():
    robot = robot_of("caroca")
    pose = home_pose(robot)[0]
    t = np.full((1, 8), 300.0)
    small, none = (stiffness(robot, pose[None], t, axial_stiffness=EA)[0] for EA in (1e-9, 0.0))
    known, W = stiffness(robot, pose[None], t)
    assert np.array_equal(known, none)  # missing in caroca.yaml
    length = lengths(robot, make_state(pose[:3], pose[3:]))
    assert small - none == pytest.approx((W[0] * (t[0] / length) @ W[0].T)[None], rel=1e-6, abs=1e-6)


def locked(name):
    """A robot on cables without damping, and on drums so heavy that they do not turn."""
    robot = robot_of(name)
    drum = replace(robot.cables[0].winch, inertia=1e9, viscous_friction=0.0, coulomb_friction=0.0)
    return replace(robot, cables=tuple(replace(cable, winch=drum, damping=0.0) for cable in robot.cables))


@pytest.mark.parametrize("place", [[0.0, 0.0, 1.2], [0.5, 0.2, 1.6]])
def test_the_frequency_matches_the_oscillation(place):
    robot = locked("caroca_winches")
    pose = np.array([*place, 1.0, 0.0, 0.0, 0.0])
    told = answers.frequency(robot, pose[None], Question())
    tension = distribute(robot, pose[None]).tension
    K, _ = stiffness(robot, pose[None], tension)
    squares, ways = np.linalg.eig(np.linalg.solve(inertia(robot, pose[None])[0], K[0]))
    way = ways[:, np.argmin(squares.real)].real
    backend = plant("reference", robot)
    backend.command[:] = tension[0]
    backend.reset(make_state(pose[:3], pose[3:]))
    push = inertia(robot, pose[None])[0] @ way
    backend.external[:] = 1e-3 * push  # about a place beside this one, by some micrometres
    moved = np.empty(3000)
    for k in range(len(moved)):
        backend.step(1)
        moved[k] = np.concatenate([backend.state[:3] - pose[:3], 2.0 * backend.state[4:7]]) @ push
    moved -= 0.5 * (moved.max() + moved.min())
    before = np.flatnonzero((moved[:-1] < 0.0) & (moved[1:] >= 0.0))
    when = 1e-3 * (before - moved[before] / (moved[before + 1] - moved[before]))
    assert len(when) >= 5
    assert told.value[0] == pytest.approx(1.0 / np.diff(when).mean(), rel=FREQUENCY)


def test_directional_stiffness_matches_a_push():
    robot = robot_of("caroca_winches")
    pose = home_pose(robot)[0]
    K, _ = stiffness(robot, pose[None], distribute(robot, pose[None]).tension)
    softest = answers.stiff(robot, pose[None], Question(length=1.0)).value[0]
    for k, name in enumerate(robot.dof):
        along = answers.stiff(robot, pose[None], Question(direction=name)).value[0]
        moved = np.linalg.solve(K[0], np.eye(6)[k])
        assert along == pytest.approx(1.0 / moved[k])
        assert along >= softest


def hanging(height, model):
    """A planar body on two crossed cables, anchored `height` above its mass."""
    robot = robot_of("planar")
    ends = [([-1.0, 0.0, 3.0], [-0.2, 0.0, height]), ([1.0, 0.0, 3.0], [0.2, 0.0, height])]
    cables = tuple(
        replace(cable, frame=np.array(frame), platform=np.array(tip), tension_min=0.0, axial_stiffness=model)
        for cable, (frame, tip) in zip(robot.cables, ends, strict=False)
    )
    return replace(robot, cables=cables)


@pytest.mark.parametrize("model", [None, 1e6])
def test_suspended_bodies_are_stable_and_inverted_ones_are_not(model):
    """Two cables leave it one motion, which its weight takes back or not (thesis, figure 2.3)."""
    pose = np.array([[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]])
    low, high = (answers.stable(hanging(height, model), pose, Question()).value[0] for height in (0.3, -2.5))
    assert low > 0.0
    assert high < 0.0


def test_on_rigid_cables_that_leave_no_motion_nothing_gives():
    robot = robot_of("caroca")
    assert answers.stable(robot, home_pose(robot)[0][None], Question()).value[0] == np.inf


def test_infeasible_poses_have_no_stiffness():
    robot = robot_of("caroca_winches")
    away = np.array([[0.0, 0.0, 9.0, 1.0, 0.0, 0.0, 0.0]])
    for answer in (answers.stiff, answers.stable, answers.frequency):
        assert np.isnan(answer(robot, away, Question()).value[0])


def test_dexterity_is_the_inverse_of_the_condition():
    robot = robot_of("cogiro")
    pose = home_pose(robot)[0]
    W = wrench_matrix(robot, make_state(pose[:3], pose[3:])).copy()
    W[3:] /= 0.5
    found = answers.dexterity(robot, pose[None], Question(length=0.5))
    assert found.value[0] == pytest.approx(1.0 / np.linalg.cond(W))
