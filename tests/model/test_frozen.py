"""Robots, runs and what else holds read-only arrays: it is as read-only when it was copied or sent."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from conftest import ROOT

import cdpr

ROBOT = str(ROOT / "scenarios" / "robots" / "cogiro_pulleys.yaml")


def sent(value):
    return pickle.loads(pickle.dumps(value))


def arrays(value):
    """All arrays in an object of data, and in what it holds."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, dict | list | tuple):
        for item in value.values() if isinstance(value, dict) else value:
            yield from arrays(item)
    elif is_dataclass(value):
        held = dict.fromkeys(field.name for field in fields(value)) | getattr(value, "__dict__", {})
        for name in held:
            yield from arrays(getattr(value, name))


@pytest.fixture(scope="module")
def robot():
    robot = cdpr.load_robot(ROBOT, overrides={"frame.shape": "box"})
    assert robot.anchors.shape == (8, 6)  # and is kept
    return robot


@pytest.mark.parametrize("passed", [copy.copy, copy.deepcopy, sent])
def test_a_robot_stays_read_only(robot, passed):
    found = list(arrays(passed(robot)))
    assert len(found) == len(list(arrays(robot))) > 2 * robot.m + 4
    assert not any(array.flags.writeable for array in found)
    assert np.array_equal(passed(robot).anchors, robot.anchors)


def test_so_do_runs_and_admissible_sets():
    run = sent(cdpr.simulate("caroca", overrides={"simulation.duration": 0.01}))
    assert not run.rows.flags.writeable
    robot = cdpr.load_robot("caroca")
    admissible = sent(cdpr.admissible(robot, robot.home))
    assert len(found := list(arrays(admissible))) == 9
    assert not any(array.flags.writeable for array in found)
