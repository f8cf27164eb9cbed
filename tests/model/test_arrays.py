"""No compiled code is given an array of a caller that it has not the size for."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.analysis.distribution.survey import survey
from cdpr.base.errors import CdprError
from cdpr.mechanics import kinematics
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.forward_kinematics import forward_kinematics
from cdpr.model.arrays import checked, live
from cdpr.plugins.registry import registry
from cdpr.tension.closure import positive_null_vector
from cdpr.tension.problem import Problem
from cdpr.trajectory import Trajectory, hold

GRAVITY = [0.0, 0.0, -9.81]
POSE = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
STATE = np.concatenate([POSE, np.zeros(6)])


@pytest.fixture(scope="module")
def robot():
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")


def reset_backend(robot, state):
    entry = registry().get("backend", "reference")
    entry.make(robot, np.array(GRAVITY), 1e-3, entry.read_options({})).reset(state)


CALLS = {
    "lengths": lambda robot: kinematics.lengths(robot, POSE),
    "rates": lambda robot: kinematics.rates(robot, STATE[:9]),
    "wrench_matrix": lambda robot: kinematics.wrench_matrix(robot, STATE[None]),
    "wrench_matrix_rate": lambda robot: kinematics.wrench_matrix_rate(robot, STATE[:12]),
    "make_state": lambda robot: kinematics.make_state([0.0, 1.0]),
    "make_state of complex numbers": lambda robot: kinematics.make_state([0.0, 1.0, 2.0j]),
    "required_wrench, state": lambda robot: required_wrench(robot, POSE, GRAVITY),
    "required_wrench, gravity": lambda robot: required_wrench(robot, STATE, GRAVITY[:2]),
    "required_wrench, acceleration": lambda robot: required_wrench(robot, STATE, GRAVITY, [0.0]),
    "forward_kinematics": lambda robot: forward_kinematics(robot, np.ones(7), POSE),
    "survey": lambda robot: survey(robot, np.zeros(3), np.zeros((2, 19)), np.array(GRAVITY), lambda *_: 0),
    "problem, pose": lambda robot: Problem(robot, POSE[:6], np.zeros(6)),
    "problem, wrench": lambda robot: Problem(robot, POSE, np.zeros(3)),
    "positive_null_vector": lambda robot: positive_null_vector(np.zeros(6)),
    "trajectory without segments": lambda robot: Trajectory(np.zeros((0, 42))),
    "trajectory of another width": lambda robot: Trajectory(np.zeros((42, 2))),
    "sampler": lambda robot: hold(POSE[:3], POSE[3:]).sampler(np.zeros(13)),
    "sampler in single precision": lambda robot: hold(POSE[:3], POSE[3:]).sampler(np.zeros(19, np.float32)),
    "sampler of every second": lambda robot: hold(POSE[:3], POSE[3:]).sampler(np.zeros(38)[::2]),
    "backend": lambda robot: reset_backend(robot, POSE),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_a_wrong_array_is_refused(robot, call):
    with pytest.raises((CdprError, ValueError), match=r"shape|real numbers|at least one|contiguous"):
        call(robot)


def test_sound_arrays_are_not_copied_and_others_are_made_sound():
    values = np.arange(3.0)
    assert checked(values, (3,), "x") is values
    assert checked(values, (None,), "x") is values
    assert live(values, (3,), "x") is values
    for other in ([0, 1, 2], np.arange(3), np.arange(6.0)[::2] / 2, np.arange(3, dtype=">f8"), np.float32([0, 1, 2])):
        found = checked(other, (3,), "x")
        np.testing.assert_array_equal(found, values)
        assert found.flags.carray
        assert found.dtype == np.float64
    values.flags.writeable = False
    assert checked(values, (3,), "x").flags.writeable


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (["1", "2", "3"], "x: expected real numbers, got an array of <U1"),
        ([None, 1.0, 2.0], "x: expected real numbers, got an array of object"),
        ([[1.0], 2.0, 3.0], "x: expected numbers: "),
        (np.zeros((3, 1)), r"x: the shape must be \(3,\), got \(3, 1\)"),
        ([0.0, np.nan, 0.0], "x: all numbers must be finite"),
    ],
)
def test_errors_are_reported_to_the_client(values, text):
    with pytest.raises(CdprError, match=text):
        checked(values, (3,), "x", finite=True)
