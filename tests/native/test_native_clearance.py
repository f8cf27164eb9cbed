"""Clearances, rays and limits of cables in the kernel library: decisions of the loop, and inputs that are refused."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from workspace_cases import poses_of, robot_of

from cdpr.mechanics.clearance import clearance
from cdpr.native import library
from cdpr.native.bind import bind
from cdpr.native.operations import operations
from cdpr.tension.status import Status


def test_the_loop_matches_clearances_of_unbroken_cables():
    robot = robot_of("caroca")
    among, edge, decided = clearance(robot, diameter=0.01), 0.05, []
    gone = np.full(robot.m, math.inf)
    gone[[1, 4]] = 0.5, 1.0
    pose, present = np.zeros(7), np.full(robot.m, np.nan)
    given = {**among.bodies._asdict(), "pose": pose, "gone": gone, "present": present}
    too_near = bind("too_near", **given, clearance=edge, after=0.2)
    for place in poses_of(robot, 100):
        pose[:] = place
        for time in (0.1, 0.2, 0.5, 2.0):
            there = among.without(np.flatnonzero(gone <= time))
            expected = time >= 0.2 and there.at(place[None])[0][0] <= edge
            assert too_near(time) == expected
            assert np.array_equal(np.isinf(present), gone <= time)
            decided.append(expected)
    assert 20 < sum(decided) < 380


@pytest.mark.parametrize("name", ["clearances", "too_near", "search_rays", "forward_kinematics", "prove"])
def test_rows_without_both_anchors_are_refused(name):
    """Packed by hand: `bind` would reject them. Nothing is read, for all addresses are 0."""
    operation = operations()[name]
    sizes = {"m": 3, "w": 5}
    words = struct.pack(operation.layout, *(sizes.get(field.name, 0) for field in operation.fields))
    expected = 0 if name == "forward_kinematics" else Status.BAD_INPUT  # no iterations
    assert library.Bound(operation.address, words, {}, ())() == expected
