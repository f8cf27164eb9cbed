"""Lengths, rates and wrench matrix of a robot at a state. See `cdpr.model` for the conventions."""

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
    """Return a state (13,): position [m], quaternion w, x, y, z, velocity [m/s], angular velocity [rad/s], world axes.

    All functions of this module raise CdprError if an array has the wrong shape or does not contain real numbers.
    """
    parts = (
        checked(position, (3,), "position"),
        checked(orientation, (4,), "orientation"),
        checked(velocity, (3,), "velocity"),
        checked(angular_velocity, (3,), "angular velocity"),
    )
    return np.concatenate(parts)


def lengths(robot: Robot, state: Array) -> Array:
    """Return the cable lengths (m,) [m] at a state (13,), the inverse kinematics."""
    return _geometry(robot, state).lengths.copy()


def rates(robot: Robot, state: Array) -> Array:
    """Return the rates of the cable lengths (m,) [m/s] at a state (13,): -W^T twist."""
    return _geometry(robot, state).rates.copy()


def wrench_matrix(robot: Robot, state: Array) -> Array:
    """Return the wrench matrix W (6, m) at a state (13,).

    W @ tension is the force and the moment about the platform's origin, in world axes.
    """
    return _geometry(robot, state).W.copy()


def wrench_matrix_rate(robot: Robot, state: Array) -> Array:
    """Return the time derivative (6, m) of the wrench matrix at a state (13,) with its twist."""
    return cable_geometry.wrench_matrix_rate(line_table(robot), checked(state, (13,), "state"))


def _geometry(robot: Robot, state: Array) -> _Geometry:
    """Return the geometry at a state. Its arrays are valid until the next call."""
    if getattr(_last, "robot", None) is not robot:
        _last.geometry, _last.robot = _Geometry(robot), robot
    geometry: _Geometry = _last.geometry
    geometry.state[:] = checked(state, (13,), "state")
    geometry.call()
    return geometry


class _Geometry:
    """Operation bound to the arrays of one robot."""

    def __init__(self, robot: Robot) -> None:
        m = robot.m
        self.state, self.W, self.lengths, self.rates = np.empty(13), np.empty((6, m)), np.empty(m), np.empty(m)
        written = {"matrix": self.W, "length": self.lengths, "rate": self.rates}
        self.call = bind("geometry", lines=line_table(robot), state=self.state, **written)


_last = threading.local()  # consecutive calls often concern one robot
