"""Potential energy of platforms on cables, against numpy and differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from kernel_cases import numbers, run
from resting_robots import energy_of, random_case

import cdpr
from cdpr.base.errors import CdprError
from cdpr.cables import chain_of
from cdpr.cables.tables import chain_table, line_table
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.potential import Potential, rest_lengths

pytestmark = pytest.mark.core
DOWN = (0.0, 0.0, -9.81)
ROUND_OFF = 1e-14  # some roundings of double precision, 2e-16 each
seeds = st.integers(0, 2**32 - 1)


def at(seed, share=0.05):
    """A random robot with a given length or tension of each cable, and a pose near its start."""
    robot, unwound, tension, start = random_case(seed)
    potential = Potential(robot, DOWN, unwound, tension)
    potential.penalty[potential.rigid] = 50.0 * potential.weight / potential.size
    potential.force[potential.rigid] = 0.1 * potential.weight
    step = share * potential.size * np.random.default_rng(seed).normal(size=robot.n)
    return potential, potential.moved(start, step)


@given(seeds)
def test_energies_of_springs_and_weight_are_those_of_numpy(seed):
    robot, unwound, tension, start = random_case(seed)
    potential = Potential(robot, DOWN, unwound, tension)
    ideal = potential.rigid.copy()
    found = potential.evaluate(start)[0]
    expected = energy_of(robot, np.where(ideal, np.nan, unwound), np.where(ideal, 0.0, tension), start)
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-9 * potential.weight * potential.size)


@given(seeds)
def test_the_gradient_is_that_of_differences(seed):
    potential, pose = at(seed)
    _, gradient, _ = potential.evaluate(pose)
    if not np.isfinite(gradient).all():  # inside a pulley
        return
    h = 1e-6 * potential.size
    steps = h * np.eye(potential.robot.n)
    difference = [
        (potential.evaluate(potential.moved(pose, e))[0] - potential.evaluate(potential.moved(pose, -e))[0])
        for e in steps
    ]
    stiffest = float(np.abs(potential.slope).max()) + potential.weight / potential.size
    np.testing.assert_allclose(gradient, np.array(difference) / (2.0 * h), rtol=1e-4, atol=3.0 * stiffest * h)


@given(seeds)
@example(1416)  # no taut cable
def test_the_hessian_is_that_of_differences_while_no_cable_changes_state(seed):
    potential, pose = at(seed)
    _, _, hessian = potential.evaluate(pose)
    if not np.isfinite(hessian).all():
        return
    taut = potential.tension > 0.0
    h = 1e-5 * potential.size
    found = np.empty_like(hessian)
    for k, e in enumerate(h * np.eye(potential.robot.n)):
        ends = []
        for sign in (1.0, -1.0):
            ends.append(potential.evaluate(potential.moved(pose, sign * e))[1])
            if ((potential.tension > 0.0) != taut).any() or potential.length.min() < 0.01 * potential.size:
                return
        found[:, k] = (ends[0] - ends[1]) / (2.0 * h)
    # differences along rotations about fixed axes are symmetric up to half the moments; without stiffness, the moments
    # of the weight leave round-off
    bound = 2e-4 * np.abs(hessian).max() + ROUND_OFF * potential.weight * potential.size
    np.testing.assert_allclose(0.5 * (found + found.T), hessian, rtol=2e-4, atol=bound)
    np.testing.assert_array_equal(hessian, hessian.T)


def test_rest_lengths_are_those_of_hooke_with_pulleys_and_without():
    rng = np.random.default_rng(1)
    for name in ("caroca_winches", "cogiro_pulleys", "caroca"):
        robot = cdpr.load_robot(name)
        poses = np.tile(robot.home, (50, 1))
        poses[:, :3] += rng.uniform(-0.2, 0.2, (50, 3))
        tension = rng.uniform(0.0, 2000.0, (50, robot.m))
        path = np.array([lengths(robot, make_state(pose[:3], pose[3:])) for pose in poses])
        stretches = [chain_of(robot, cable).stretches for cable in robot.cables]
        strain = np.array(
            [0.0 if not on else 1.0 / cable.axial_stiffness for cable, on in zip(robot.cables, stretches, strict=True)]
        )
        found = rest_lengths(robot, poses, tension)
        np.testing.assert_allclose(found, path / (1.0 + tension * strain), rtol=1e-14)
        np.testing.assert_array_equal(found, rest_lengths(robot, poses, tension, jobs=1))


def test_kernels_have_the_same_bits_on_each_instruction_set_with_hostile_numbers():
    """Each call gets rubbish in its work space; spring flags and the table of cables are those of the robots."""
    rng, count = np.random.default_rng(4), 300
    for seed in (3, 8, 21):
        robot, unwound, tension, start = random_case(seed)
        m, flags = robot.m, Potential(robot, DOWN, unwound, tension).spring
        fixed = {"lines": np.array(line_table(robot)), "chains": np.array(chain_table(robot))}
        tables = {key: np.tile(value, (count, 1, 1)) for key, value in fixed.items()}
        given = {"inertial": 13, "gravity": 3, "pose": 7, "unwound": m, "force": m, "penalty": m}
        inputs = {**tables, **{key: numbers(rng, count, size) for key, size in given.items()}}
        inputs["pose"][::2], inputs["unwound"][::2] = start, unwound  # a cable without length has no energy
        shapes = {"energy": (1,), "gradient": (6,), "hessian": (6, 6), "matrix": (6, m)}
        shapes |= dict.fromkeys(("length", "tension", "slope", "shift"), (m,)) | {"response": (6, m)}
        found, codes = run("potential", inputs, shapes, spring=flags)
        assert (codes == 0).all()
        assert np.isfinite(found["energy"]).any()
        inputs = {**tables, "gravity": inputs["gravity"], "poses": inputs["pose"][:, None]}
        inputs["tension"] = numbers(rng, count, 1, m)
        assert (run("rest_lengths", inputs, {"unwound": (1, m)})[1] == 0).all()


def test_wrong_shapes_are_refused():
    robot = cdpr.load_robot("caroca")
    with pytest.raises(CdprError, match="tension: the shape must be"):
        rest_lengths(robot, robot.home[None], np.ones((2, 8)))
    with pytest.raises(CdprError, match="poses: the shape must be"):
        rest_lengths(robot, robot.home, np.ones((1, 8)))
