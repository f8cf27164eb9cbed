"""Observation of the plant at a new sample: cable geometry, energies, and faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind

# Faster than any cable robot by two orders: the run has diverged. As in observe.hpp.
SPEED_MAX = 1e3  # m/s
ANGULAR_SPEED_MAX = 1e4  # rad/s


def acceleration_bounds(robot: Robot, gravity: Array) -> Array:
    """Return the bounds of the platform's accelerations, (7,), for `observe`.

    They are: 1 / mass; |gravity|; distance of the centre of mass from the origin; largest lever arm of a cable, or of a
    wrench at the origin, about the centre of mass; 1 / smallest principal moment; largest ratio of the gyroscopic
    angular acceleration to the squared angular speed; 1 if the force that holds the origin turns the platform, as in a
    pendulum, else 0.
    """
    platform = robot.platform
    moments = np.linalg.eigvalsh(platform.inertia)
    arm = float(np.linalg.norm(platform.center_of_mass))
    reach = float(np.linalg.norm(robot.anchors[:, 3:] - platform.center_of_mass, axis=1).max())
    ratio = (moments[2] - moments[0]) / moments[0]
    weight = float(np.linalg.norm(gravity))
    turns = sum(name.startswith("r") for name in robot.dof)
    swings = arm > 0.0 and turns > 0 and robot.n - turns < 3
    return np.array([1.0 / platform.mass, weight, arm, max(reach, arm), 1.0 / moments[0], ratio, swings])


class Body(NamedTuple):
    """Constants of the moving body of a robot with m cables."""

    lines: Array  # as of `cdpr.cables.tables.line_table`
    inertial: Array  # (13,), as `Robot.inertial`
    gravity: Array  # (3,), m/s^2
    bounds: Array  # (7,), as `acceleration_bounds` returns


class PlantOutputs(NamedTuple):
    """Live outputs of a backend."""

    state: Array  # (13,)
    external: Array  # (6,), wrench in the last control period, N and N m
    highest: Array  # (m,), N, upper bound of each tension; with ideal cables the tension itself


class Observation(NamedTuple):
    """Quantities computed from these, in the present sample."""

    state: Array  # (13,)
    matrix: Array  # (6, m), wrench matrix
    length: Array  # (m,), m
    rate: Array  # (m,), m/s
    energies: Array  # (4,), J: kinetic, potential, and the works so far of ideal cables and of the external wrench


def observing(body: Body, shown: PlantOutputs, seen: Observation, period: float) -> Callable[[], int]:
    """Return a bound operation that writes `seen`, and returns 0 or a key of FAULTS.

    Before the call, state and lengths in `seen` are those of one control `period` (s) earlier. After a fault they and
    the energies are unchanged. The work of a held tension is exactly tension times shortening; a period of 0 resets the
    works.
    """
    return bind(
        "observe",
        **body._asdict(),
        live=shown.state,
        external=shown.external,
        highest=shown.highest,
        **seen._asdict(),
        period=period,
    )


def observing_nominal(lines: Array, state: Array, matrix: Array) -> Callable[[], int]:
    """Return a bound operation that writes the wrench matrix (6, m) of the perceived robot at the seen `state` (13,).

    `lines` is the table of that robot, as of `cdpr.cables.tables.line_table`.

    It returns 0 or a key of FAULTS.
    """
    length, rate = np.zeros(len(lines)), np.zeros(len(lines))
    return bind("observe_nominal", lines=lines, state=state, matrix=matrix, length=length, rate=rate)
