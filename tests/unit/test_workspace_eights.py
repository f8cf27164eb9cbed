"""Poses that are asked for eight at a time are answered to the bit as alone."""

from __future__ import annotations

import dataclasses
import importlib

import numpy as np
import pytest
from spread import sampled
from test_workspace import poses_of, robot_of

from cdpr.workspace.required import NOTHING, box, ellipsoid, vertices

measures = importlib.import_module("cdpr.workspace.measure")

ROBOTS = ["cogiro", "caroca", "ipanema_1", "seven", "planar", "nine", "cogiro_pulleys"]
QUESTIONS = {
    "weight": ("margin", NOTHING),
    "box": ("margin", box([50, 40, 30, 5, 4, 3])),
    "ellipsoid": ("margin", ellipsoid([50, 40, 30, 5, 4, 3])),
    "corners": ("margin", vertices(np.random.default_rng(1).normal(size=(5, 6)))),
    "accelerations": ("margin", box([1, 2, 3, 0.1, 0.2, 0.3], accelerations=True)),
    "closure": ("closure", NOTHING),
    "payload": ("payload", NOTHING),
}
COUNT = 1003  # no multiple of eight
NEVER = 10**9


@sampled(2, "name", ROBOTS)
@pytest.mark.parametrize("question", QUESTIONS)
def test_margins(name, question, monkeypatch):
    robot, (mode, required) = robot_of(name), QUESTIONS[question]
    poses = poses_of(robot, COUNT)
    poses[7::40] = poses[0]
    together = measures.measure(robot, poses, mode, required)
    few = measures.measure(robot, poses[3:90], mode, required)
    monkeypatch.setattr(measures, "MANY", NEVER)
    alone = measures.measure(robot, poses, mode, required)
    for field in ("value", "scale", "singular", "limit", "direction"):
        one, other = getattr(together, field), getattr(alone, field)
        assert np.array_equal(one, other, equal_nan=one.dtype.kind == "f"), field
        assert np.array_equal(getattr(few, field), other[3:90], equal_nan=one.dtype.kind == "f"), field


def test_poses_without_rank_do_not_disturb_their_neighbours(monkeypatch):
    robot = robot_of("ipanema_1")
    poses = poses_of(robot, COUNT)
    poses[::3, :3] = robot.home[:3]
    poses[::3, 2] = np.linspace(-1e-9, 1e-9, len(poses[::3]))
    poses[::3, 3:] = (1.0, 0.0, 0.0, 0.0)
    together = measures.measure(robot, poses)
    monkeypatch.setattr(measures, "MANY", NEVER)
    alone = measures.measure(robot, poses)
    assert np.array_equal(together.value, alone.value, equal_nan=True)
    assert np.array_equal(together.singular, alone.singular)


@pytest.mark.parametrize("mode", ["margin", "closure", "payload"])
def test_robots_whose_matrix_never_has_full_rank_harm_nothing(mode):
    """More columns of the null space than two are written then, into memory that must be there."""
    robot = robot_of("cogiro")
    cables = tuple(dataclasses.replace(cable, platform=np.zeros(3)) for cable in robot.cables)  # all to one point
    robot = dataclasses.replace(robot, cables=cables)
    for _ in range(20):
        found = measures.measure(robot, poses_of(robot, COUNT), mode)
        assert found.singular.all()
        assert np.isnan(found.value).all()
