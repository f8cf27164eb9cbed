"""Lengths, rates and the wrench matrix of a robot at a state. Conventions: see `cdpr.model`."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.mechanics import cable_geometry
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
STILL = (0.0, 0.0, 0.0)


def make_state(
    position: Sequence[float] | Array,
    orientation: Sequence[float] | Array = UPRIGHT,
    velocity: Sequence[float] | Array = STILL,
    angular_velocity: Sequence[float] | Array = STILL,
) -> Array:
    """Return a state (13,): position (m), quaternion w, x, y, z, velocity (m/s), angular velocity (rad/s), world.

    Here and below CdprError is raised where an array has not the shape that it must have, or holds no real numbers.
    """
    parts = (
        checked(position, (3,), "position"),
        checked(orientation, (4,), "orientation"),
        checked(velocity, (3,), "velocity"),
        checked(angular_velocity, (3,), "angular velocity"),
    )
    return np.concatenate(parts)


def lengths(robot: Robot, state: Array) -> Array:
    """Cable lengths (m,), m, at a state (13,): the inverse kinematics."""
    return _geometry(robot, state).lengths.copy()


def rates(robot: Robot, state: Array) -> Array:
    """Rates of the cable lengths (m,), m/s, at a state (13,): -W^T twist."""
    return _geometry(robot, state).rates.copy()


def wrench_matrix(robot: Robot, state: Array) -> Array:
    """Wrench matrix W (6, m) at a state (13,): W @ tension is force and moment about the origin, world axes."""
    return _geometry(robot, state).W.copy()


def wrench_matrix_rate(robot: Robot, state: Array) -> Array:
    """Time derivative (6, m) of the wrench matrix at a state (13,) with its twist."""
    return cable_geometry.wrench_matrix_rate(line_table(robot), checked(state, (13,), "state"))


def _geometry(robot: Robot, state: Array) -> _Geometry:
    """Return the geometry at a state; its arrays hold until the next call."""
    if getattr(_last, "robot", None) is not robot:
        _last.geometry, _last.robot = _Geometry(robot), robot
    geometry: _Geometry = _last.geometry
    geometry.state[:] = checked(state, (13,), "state")
    geometry.call()
    return geometry


class _Geometry:
    """The operation bound to arrays for one robot."""

    def __init__(self, robot: Robot) -> None:
        m = robot.m
        self.state, self.W, self.lengths, self.rates = np.empty(13), np.empty((6, m)), np.empty(m), np.empty(m)
        written = {"matrix": self.W, "length": self.lengths, "rate": self.rates}
        self.call = bind("geometry", lines=line_table(robot), state=self.state, **written)


_last = threading.local()  # the same robot comes many times in a row
