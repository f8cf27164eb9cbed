"""The pose from the cable lengths: exact, noisy, ambiguous and wrong."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from conftest import ROOT, crossed_box, make_robot, random_state
from hypothesis import given
from hypothesis import strategies as st

from cdpr.base.errors import CdprError
from cdpr.mechanics import kinematics
from cdpr.mechanics.forward_kinematics import forward_kinematics
from cdpr.model import rotations
from cdpr.scenario import load_robot

EXACT = 1e-10  # m and rad; measured 1e-13

FEW = {"v_plotter"}  # fewer cables than degrees of freedom
ROBOTS = sorted({path.stem for path in (ROOT / "scenarios" / "robots").glob("*.yaml")} - FEW)
seeds = st.integers(0, 2**32 - 1)


def moved(robot, pose, twist):
    """`pose` (7,) moved by a twist (6,), of which only the robot's degrees of freedom count."""
    free = np.zeros(6)
    free[robot.rows] = np.asarray(twist)[robot.rows]
    angle = float(np.linalg.norm(free[3:]))
    turn = rotations.from_axis_angle(free[3:] / angle, angle) if angle > 0 else np.array([1.0, 0, 0, 0])
    return np.concatenate([pose[:3] + free[:3], rotations.multiply(turn, pose[3:])])


def lengths(robot, pose):
    return kinematics.lengths(robot, np.concatenate([pose, np.zeros(6)]))


def deviation(pose, other):
    """The twist (6,) that takes `other` to `pose`."""
    turn = rotations.multiply(pose[3:], rotations.conjugate(other[3:]))
    return np.concatenate([pose[:3] - other[:3], rotations.rotation_vector(turn)])


@pytest.mark.parametrize("name", ROBOTS)
def test_recovers_the_pose_of_every_robot(name):
    """Starts are off by 0.1 m and 0.1 rad in each degree of freedom."""
    robot, rng = load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml"), np.random.default_rng(3)
    for _ in range(100):
        pose = moved(robot, robot.home, rng.uniform(-0.2, 0.2, 6))
        fit = forward_kinematics(robot, lengths(robot, pose), moved(robot, pose, rng.uniform(-0.1, 0.1, 6)))
        assert fit.converged
        assert fit.iterations < 10
        assert np.abs(deviation(fit.pose, pose)).max() < EXACT
        assert fit.residual < EXACT
        assert fit.covariance.shape == (robot.n, robot.n)


def test_at_the_solution_one_iteration_is_enough():
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    pose = random_state(np.random.default_rng(1))[:7]
    assert forward_kinematics(robot, lengths(robot, pose), pose).iterations == 1


@given(seeds, st.integers(8, 12))
def test_it_is_the_least_squares_optimum(seed, m):
    """With noisy lengths no nearby pose fits better, and the gradient vanishes."""
    rng = np.random.default_rng(seed)
    robot = make_robot(crossed_box(rng, m))
    pose = random_state(rng)[:7]
    measured = lengths(robot, pose) + 1e-3 * rng.normal(size=m)
    fit = forward_kinematics(robot, measured, pose)
    assert fit.converged
    rest = measured - lengths(robot, fit.pose)
    assert fit.residual == pytest.approx(np.linalg.norm(rest), abs=1e-12)
    W = kinematics.wrench_matrix(robot, np.concatenate([fit.pose, np.zeros(6)]))
    assert np.abs(W @ rest).max() < 1e-10
    for _ in range(5):
        other = moved(robot, fit.pose, 1e-3 * rng.normal(size=6))
        assert np.linalg.norm(measured - lengths(robot, other)) >= fit.residual - 1e-12


def test_from_far_away_damping_helps_and_no_fit_is_worse_than_its_start():
    """Starts up to a metre and 0.8 rad off in each direction: 88 of 200 find back, 44 without damping."""
    rng = np.random.default_rng(9)
    robot, pose = make_robot(crossed_box(np.random.default_rng(0), 8)), np.array([0, 0, 2.0, 1.0, 0, 0, 0])
    target, found = lengths(robot, pose), 0
    for _ in range(200):
        start = moved(robot, pose, np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-0.8, 0.8, 3)]))
        fit = forward_kinematics(robot, target, start)
        assert fit.residual <= np.linalg.norm(target - lengths(robot, start))
        found += fit.converged and np.abs(deviation(fit.pose, pose)).max() < EXACT
    assert found > 80


def test_turns_in_world_axes_from_any_attitude():
    """Turned upside down and back to front it works as well as upright, with either sign of the quaternion."""
    rng = np.random.default_rng(5)
    upright = crossed_box(rng, 8)
    for rpy in ([0.0, np.pi / 2, 0.0], [np.pi, 0.0, 0.0], [0.3, -np.pi / 2, 2.0]):
        q = rotations.from_rpy(*rpy)
        anchors = upright.copy()
        anchors[:, 3:] = upright[:, 3:] @ rotations.matrix(q)  # the same robot, its platform's axes turned
        robot = make_robot(anchors)
        pose = np.concatenate([[0.1, 0.2, 2.1], q])
        for sign in (1.0, -1.0):
            start = moved(robot, pose, rng.uniform(-0.1, 0.1, 6)) * np.repeat([1.0, sign], [3, 4])
            fit = forward_kinematics(robot, lengths(robot, pose), start)
            assert np.abs(deviation(fit.pose, pose)).max() < EXACT
            assert np.sign(fit.pose[3:] @ start[3:]) == 1.0


@pytest.mark.parametrize("dof", [("x", "y", "z", "rx", "ry", "rz"), ("x", "z", "ry")])
@pytest.mark.usual("dof1")
def test_the_covariance_is_that_of_many_noisy_fits(dof):
    rng = np.random.default_rng(2)
    sigma, count = 1e-4, 2000
    robot = dataclasses.replace(make_robot(crossed_box(rng, 8)), dof=dof)
    pose = moved(robot, np.array([0.1, 0.0, 2.1, 1.0, 0, 0, 0]), [0, 0, 0, 0.1, 0.2, -0.1])
    exact = lengths(robot, pose)
    deviations, estimates = [], []
    for _ in range(count):
        measured = exact + sigma * rng.normal(size=8)
        fit = forward_kinematics(robot, measured, pose, sigma=sigma)
        deviations.append(deviation(fit.pose, pose)[robot.rows])
        estimates.append(forward_kinematics(robot, measured, pose).covariance)
    scatter = np.cov(np.array(deviations).T)
    scale = np.sqrt(np.diag(scatter))
    # The standard error of a sample variance is sqrt(2 / count) = 3 %; four of them.
    np.testing.assert_allclose(fit.covariance / np.outer(scale, scale), scatter / np.outer(scale, scale), atol=0.13)
    estimate = np.mean(estimates, axis=0)
    np.testing.assert_allclose(estimate / np.outer(scale, scale), fit.covariance / np.outer(scale, scale), atol=0.13)


def test_without_spare_lengths_the_noise_must_be_given():
    robot = make_robot(crossed_box(np.random.default_rng(0), 6))
    pose = random_state(np.random.default_rng(1))[:7]
    assert np.isnan(forward_kinematics(robot, lengths(robot, pose), pose).covariance).all()
    assert np.isfinite(forward_kinematics(robot, lengths(robot, pose), pose, sigma=1e-3).covariance).all()


def test_an_unobservable_turn_is_no_convergence():
    """With all platform anchors in the origin, lengths do not determine the attitude."""
    anchors = crossed_box(np.random.default_rng(0), 8)
    anchors[:, 3:] = 0.0
    robot = make_robot(anchors)
    pose = np.array([0.1, 0.2, 2.0, 1.0, 0, 0, 0])
    fit = forward_kinematics(robot, lengths(robot, pose), moved(robot, pose, [0.05, 0, 0, 0, 0, 0]), sigma=1e-3)
    assert not fit.converged
    assert np.isinf(fit.covariance).all()
    assert np.isfinite(fit.pose).all()


def test_lengths_that_no_pose_has_show_in_the_residual():
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    start = np.array([0, 0, 2.0, 1.0, 0, 0, 0])
    fit = forward_kinematics(robot, lengths(robot, start) + np.array([0.3, -0.3] * 4), start)
    assert fit.residual > 0.1
    assert np.isfinite(fit.pose).all()


@pytest.mark.parametrize("wrong", [0, 5])
def test_a_wrong_length_is_named_if_enough_others_agree(wrong):
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    target = lengths(robot, GOOD)
    target[wrong] -= 0.6
    fit = forward_kinematics(robot, target, GOOD)
    assert not fit.converged
    assert fit.suspect == wrong
    assert forward_kinematics(robot, lengths(robot, GOOD), GOOD).suspect is None
    target[(wrong + 2) % 8] += 0.6
    assert forward_kinematics(robot, target, GOOD).suspect is None  # two are wrong
    few = robot.replace(cables=robot.cables[:7])
    assert forward_kinematics(few, target[:7], GOOD).suspect is None


GOOD = np.array([0.0, 0, 2, 1, 0, 0, 0])


@pytest.mark.parametrize(
    ("target", "start", "text"),
    [
        (np.full(7, 2.0), GOOD, r"lengths: the shape must be \(8,\), got \(7,\)"),
        (np.full((8, 1), 2.0), GOOD, r"lengths: the shape must be \(8,\), got \(8, 1\)"),
        (np.full(8, np.nan), GOOD, "lengths: all numbers must be finite"),
        (np.full(8, 0.0), GOOD, "lengths must be positive"),
        (["a"] * 8, GOOD, "lengths: expected real numbers"),
        (np.full(8, 2.0), np.zeros(13), r"start: the shape must be \(7,\), got \(13,\)"),
        (np.full(8, 2.0), np.zeros(7), "quaternion has the length 0"),
        (np.full(8, 2.0), np.full(7, np.inf), "start: all numbers must be finite"),
    ],
)
def test_wrong_input_is_refused(target, start, text):
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    with pytest.raises(CdprError, match=text):
        forward_kinematics(robot, target, start)


def test_too_few_cables_and_a_bad_sigma_are_refused():
    robot = make_robot(crossed_box(np.random.default_rng(0), 5))
    with pytest.raises(CdprError, match="5 lengths do not determine 6"):
        forward_kinematics(robot, np.full(5, 2.0), GOOD)
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    for sigma in (-1.0, np.nan, np.inf):
        with pytest.raises(CdprError, match="sigma"):
            forward_kinematics(robot, np.full(8, 2.0), GOOD, sigma=sigma)


def test_the_input_is_not_changed():
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    target, start = lengths(robot, GOOD), moved(robot, GOOD, np.full(6, 0.05))
    kept = target.copy(), start.copy()
    forward_kinematics(robot, target, start)
    np.testing.assert_array_equal(target, kept[0])
    np.testing.assert_array_equal(start, kept[1])
