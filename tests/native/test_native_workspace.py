"""Margins, closure and payload in the kernel library: same bits eight at a time as alone, on each instruction set."""

from __future__ import annotations

import dataclasses
import os
from unittest.mock import patch

import numpy as np
import pytest
from kernel_cases import assert_same_bits, rubbish
from spread import sampled
from workspace_cases import poses_of, robot_of

from cdpr.analysis.workspace.measure import LACKS_RANK, NOT_FINITE, measure, pose_question
from cdpr.analysis.workspace.required import NOTHING, box, ellipsoid, vertices
from cdpr.native.bind import bind
from cdpr.native.operations import VARIABLE, operations, targets
from cdpr.tension.status import Status

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
COUNT = 203  # no multiple of eight
GRAVITY = (0.0, 0.0, -9.81)
ANSWERS = ("value", "scale", "direction", "status", "limit")


def answers(robot, poses, question, group, **given):
    """Return all answers about poses in blocks of this size, with rubbish in outputs and work spaces."""
    asked = pose_question(robot, *QUESTIONS[question], GRAVITY, None)._asdict()
    count = len(poses)
    found = {name: np.empty(count) for name in ANSWERS[:2]} | {"direction": np.empty((count, robot.n))}
    found |= {name: np.empty(count, np.int64) for name in ANSWERS[3:]}
    for start in range(0, count, group):
        cut = slice(start, start + group)
        call = bind("assess", **asked, poses=poses[cut], **{name: each[cut] for name, each in found.items()}, **given)
        for array in call.arrays:
            if array.dtype == np.float64 and not any(array is each for each in (*asked.values(), call.given["poses"])):
                rubbish(array)
        assert call() == Status.OK
    return found


def hard_poses(robot):
    """Poses among which W nearly lacks rank in some, an anchor is by the other one of its cable, and some are NaN."""
    poses = poses_of(robot, COUNT)
    poses[3::9, :3] = robot.home[:3]
    poses[3::9, 2] += np.linspace(-1e-9, 1e-9, len(poses[3::9]))
    poses[5::17, :3] = robot.anchors[0, :3] - robot.anchors[0, 3:]
    for some in (slice(3, None, 9), slice(5, None, 17)):
        poses[some, 3:] = (1.0, 0.0, 0.0, 0.0)
    poses[6::19, 1] = np.nan
    return poses


@sampled(2, "name", ROBOTS)
@pytest.mark.parametrize("question", QUESTIONS)
@pytest.mark.usual("*-cogiro")
def test_poses_are_answered_as_alone(name, question):
    robot = robot_of(name)
    poses = hard_poses(robot)
    alone = answers(robot, poses, question, 1)
    assert (alone["status"] == NOT_FINITE).any()
    for target in targets():
        with patch.dict(os.environ, {VARIABLE: target}):
            together = answers(robot, poses, question, COUNT)
        for key in ANSWERS:
            assert_same_bits(together[key], alone[key])


@pytest.mark.parametrize("mode", ["margin", "closure", "payload"])
def test_robots_whose_matrix_never_has_full_rank_harm_nothing(mode):
    """More columns of the null space than two are written then."""
    robot = robot_of("cogiro")
    cables = tuple(dataclasses.replace(cable, platform=np.zeros(3)) for cable in robot.cables)  # all to one point
    robot = dataclasses.replace(robot, cables=cables)
    found = measure(robot, poses_of(robot, COUNT), mode)
    assert found.singular.all()
    assert np.isnan(found.value).all()


@pytest.mark.parametrize("name", ["cogiro", "twelve", "point_mass", "planar"])
@pytest.mark.parametrize("question", ["corners", "payload"])
def test_nothing_is_written_beyond_the_work_space(name, question):
    robot = robot_of(name)
    asked = pose_question(robot, *QUESTIONS[question], GRAVITY, None)
    sizes = {"n": robot.n, "m": robot.m, "k": len(asked.vectors), "w": asked.lines.shape[1]}
    fields = {field.name: field for field in operations()["assess"].fields}
    guarded, whole = {}, {}
    for key in ("space", "cables", "eight", "eight_question"):
        shape = tuple(dimension.evaluate(sizes) for dimension in fields[key].shape)
        dtype = np.int64 if fields[key].type == "int64*" else np.float64
        whole[key] = np.full(int(np.prod(shape)) + 64, 77, dtype=dtype)
        guarded[key] = whole[key][: int(np.prod(shape))].reshape(shape)
    answers(robot, poses_of(robot, 16), question, 16, **guarded)
    for array in whole.values():
        assert (array[-64:] == 77).all()


def test_a_row_that_no_wrench_has_is_bad_input():
    robot = robot_of("cogiro")
    asked = pose_question(robot, "margin", NOTHING, GRAVITY, None)._replace(rows=np.array([0, 1, 2, 3, 4, 6]))
    found = {name: np.empty(1) for name in ANSWERS[:2]} | {"direction": np.empty((1, 6))}
    found |= {name: np.empty(1, np.int64) for name in ANSWERS[3:]}
    assert bind("assess", **asked._asdict(), poses=robot.home[None].copy(), **found)() == Status.BAD_INPUT


def test_a_platform_on_too_few_cables_lacks_rank():
    robot = robot_of("cogiro")
    few = dataclasses.replace(robot, cables=robot.cables[:5])
    assert (answers(few, poses_of(few, 9), "weight", 9)["status"] == LACKS_RANK).all()
