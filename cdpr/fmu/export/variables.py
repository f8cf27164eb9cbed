"""The variables of an exported plant: the one object that model description and configuration are written from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cdpr.model import Robot
from cdpr.model.guide import Guide
from cdpr.model.robot import Array

Causality = Literal["independent", "parameter", "input", "output", "constant"]

# Exponents of the base units of all units that occur, by the names of FMI's attributes.
UNITS: dict[str, dict[str, int]] = {
    "s": {"s": 1},
    "kg": {"kg": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad/s": {"rad": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}


@dataclass(frozen=True)
class Variable:
    """A variable; the C source knows it by its name.

    Attributes:
        causality: as in FMI; a constant is hidden from the host.
        shape: () for a scalar.
        unit: one for all numbers, one for each of them, or "" for numbers without unit.
        values: start values, as many as the shape says, row by row; zeros for what is calculated.
    """

    name: str
    causality: Causality
    shape: tuple[int, ...]
    unit: str | tuple[str, ...]
    values: tuple[float, ...]
    description: str

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return math.prod(self.shape)

    def unit_of(self, i: int) -> str:
        """Unit of number i."""
        return self.unit if isinstance(self.unit, str) else self.unit[i]


@dataclass(frozen=True, eq=False)
class Plant:
    """What is exported: a robot with all that its motion depends on.

    Attributes:
        gravity: (3,), m/s^2, world.
        physics_step: step of the integrator, s.
        state: (13,) initial state, laid out as `cdpr.model` says.
    """

    robot: Robot
    gravity: Array
    physics_step: float
    state: Array

    def variables(self) -> list[Variable]:
        """All variables in the order of their value references: the number of the numbers before them."""
        return [*self._parameters(), *self._inputs(), *self._outputs(), *self._constants()]

    def _parameters(self) -> list[Variable]:
        robot, state = self.robot, self.state
        platform, m = robot.platform, robot.m
        return [
            Variable("time", "independent", (), "s", (0.0,), "time"),
            _parameter("mass", (), "kg", [platform.mass], "mass of the platform"),
            _parameter(
                "center_of_mass", (3,), "m", platform.center_of_mass, "centre of mass from the origin, platform axes"
            ),
            _parameter("inertia", (3, 3), "kg.m2", platform.inertia, "inertia about the centre of mass, platform axes"),
            _parameter("gravity", (3,), "m/s2", self.gravity, "acceleration of gravity, world axes"),
            _parameter("physics_step", (), "s", [self.physics_step], "step of the integrator"),
            _parameter("frame_anchors", (m, 3), "m", robot.anchors[:, :3], "anchors on the fixed frame, world"),
            _parameter("platform_anchors", (m, 3), "m", robot.anchors[:, 3:], "anchors on the platform, platform axes"),
            _parameter(
                "initial_position", (3,), "m", state[:3], "position of the platform's origin at the start, world"
            ),
            _parameter(
                "initial_quaternion", (4,), "", state[3:7], "attitude at the start, platform to world, w, x, y, z"
            ),
            _parameter("initial_velocity", (3,), "m/s", state[7:10], "velocity of the origin at the start, world axes"),
            _parameter(
                "initial_angular_velocity", (3,), "rad/s", state[10:], "angular velocity at the start, world axes"
            ),
        ]

    def _inputs(self) -> list[Variable]:
        m = self.robot.m
        wrench = ("N",) * 3 + ("N.m",) * 3
        return [
            Variable("cable_tension", "input", (m,), "N", (0.0,) * m, "tension of each cable"),
            Variable(
                "external_wrench",
                "input",
                (6,),
                wrench,
                (0.0,) * 6,
                "further force (3) and moment (3) on the platform at its origin, world axes",
            ),
        ]

    def _outputs(self) -> list[Variable]:
        m = self.robot.m
        return [
            _output("position", 3, "m", "position of the platform's origin, world"),
            _output("quaternion", 4, "", "attitude, platform to world, w, x, y, z"),
            _output("velocity", 3, "m/s", "velocity of the origin, world axes"),
            _output("angular_velocity", 3, "rad/s", "angular velocity, world axes"),
            _output("cable_length", m, "m", "distance between the anchors of each cable"),
            _output("cable_rate", m, "m/s", "rate of change of cable_length"),
        ]

    def _constants(self) -> list[Variable]:
        if self.robot.n == 6:
            return []
        guide = tuple(Guide(self.robot).packed.tolist())
        return [Variable("guide", "constant", (6,), "", guide, "free axes (3), axis of the hinge (3)")]


def _parameter(
    name: str, shape: tuple[int, ...], unit: str, values: Sequence[float] | Array, description: str
) -> Variable:
    return Variable(name, "parameter", shape, unit, tuple(np.ravel(values).tolist()), description)


def _output(name: str, size: int, unit: str, description: str) -> Variable:
    return Variable(name, "output", (size,), unit, (0.0,) * size, description)
