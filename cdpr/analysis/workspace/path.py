"""Smallest margin, clearance and stiffness along a motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cdpr.analysis.distribution.sagging import STRAIGHT, resting_lengths
from cdpr.analysis.workspace import answers
from cdpr.analysis.workspace.question import Question, directions
from cdpr.log.interference import some_rows
from cdpr.log.run import Run
from cdpr.mechanics.assumed_diameters import assumption, with_diameters
from cdpr.mechanics.clearance import clearance
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle


def along(
    robot: Robot, time: Array, poses: Array, gravity: Array, obstacles: Sequence[Obstacle] = ()
) -> dict[str, dict[str, Any]]:
    """Return the smallest values along a motion as plain data by name, each with its time and its limit.

    "margin" is the static capacity margin, N, if all tension limits are finite. "clearance", m, assumes diameters that
    the robot does not specify, and states so; cables that sag have their curves at rest. "stiffness", N/m with moments
    divided by the characteristic length, requires the axial stiffness of all cables.

    Args:
        robot: the robot.
        time: (K,), s.
        poses: (K, 7), position (m) and quaternion w, x, y, z.
        gravity: (3,), m/s^2, world.
        obstacles: further bodies that cables may touch.
    """
    found = _forces(robot, time, poses, gravity)
    if not robot.unilateral and any(cable.diameter is None for cable in robot.cables):
        return found  # rigid legs are no cables
    among = clearance(with_diameters(robot), obstacles, gravity=gravity)
    unwound = resting_lengths(robot, poses, gravity)
    values, which = among.at(poses, unwound=unwound)
    straight = np.isnan(values if unwound is None else unwound.sum(axis=1))
    remarks = [assumption(robot) + STRAIGHT * each for each in straight.tolist()]
    least = _least(time, values, [among.name(n) + remark for n, remark in zip(which.tolist(), remarks, strict=True)])
    return found if least is None else {**found, "clearance": least}


def _forces(robot: Robot, time: Array, poses: Array, gravity: Array) -> dict[str, dict[str, Any]]:
    """Return margin and stiffness as in `along`."""
    question, found = Question(gravity=gravity), {}
    if np.isfinite(robot.tension_max).all():
        measured = answers.margin(robot, poses, question)
        names = dict(enumerate(directions(robot)))
        found["margin"] = _least(time, measured.value, [names.get(n, "") for n in measured.limit.tolist()])
    if all(cable.axial_stiffness is not None for cable in robot.cables):
        found["stiffness"] = _least(time, answers.stiff(robot, poses, question).value, [""] * len(time))
    return {name: least for name, least in found.items() if least is not None}


def flown(robot: Robot, run: Run) -> dict[str, dict[str, Any]]:
    """Return margin and stiffness, as in `along`, of the motion of a run, with the limits of `robot`.

    Cables are ignored after they broke. `robot` has the controlled degrees of freedom. (The run's summary contains the
    clearance at all samples.)
    """
    head, rows = run.header, some_rows(run)
    time, poses = rows[:, 0], np.ascontiguousarray(rows[:, head.layout.span("position", "orientation")])
    cuts, found = sorted({-math.inf, *(since for _, since in head.broken)}), dict[str, dict[str, Any]]()
    for since, until in zip(cuts, [*cuts[1:], math.inf], strict=True):
        now = (time >= since) & (time < until) & np.isfinite(poses).all(axis=1)
        gone = {cable for cable, at in head.broken if at <= since}
        left = tuple(each for i, each in enumerate(robot.cables) if i not in gone)
        if left and now.any():
            these = _forces(replace(robot, cables=left), time[now], poses[now], np.array(head.gravity))
            for name, least in these.items():
                if name not in found or least["value"] < found[name]["value"]:
                    found[name] = least
    return found


def _least(time: Array, values: Array, limits: Sequence[str]) -> dict[str, Any] | None:
    """Return the smallest finite value; None if there is none."""
    if not np.isfinite(values).any():
        return None
    k = int(np.argmin(np.where(np.isfinite(values), values, np.inf)))
    return {"value": float(values[k]), "at_s": float(time[k]), "by": limits[k]}
