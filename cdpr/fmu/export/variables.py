"""The variables of an exported plant: the one object that model description and configuration are written from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cdpr.cables.winch import COULOMB, COULOMB_SPEED, DAMPING, INERTIA, RADIUS, STIFFNESS, VISCOUS, pack
from cdpr.errors import CdprError
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
    "N.s/m": {"kg": 1, "s": -1},
    "N.m.s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
}


@dataclass(frozen=True)
class Variable:
    """A variable; the C source knows it by its name.

    Attributes:
        causality: as in FMI; a constant is hidden from the host.
        shape: () for a scalar.
        unit: one for all numbers, one for each of them, or "" for numbers without unit.
        values: start values, as many as the shape says, row by row; zeros for what is calculated.
        direct: an output that depends on inputs at the same instant.
    """

    name: str
    causality: Causality
    shape: tuple[int, ...]
    unit: str | tuple[str, ...]
    values: tuple[float, ...]
    description: str
    direct: bool = False

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
        winches: with the robot's winches, which take commands; without them the plant takes tensions.
    """

    robot: Robot
    gravity: Array
    physics_step: float
    state: Array
    winches: bool = False

    def variables(self) -> list[Variable]:
        """All variables in the order of their value references: the number of the numbers before them.

        Raises CdprError where winches are to be exported that the robot does not have.
        """
        if self.winches and self.robot.cable_model == "ideal":
            raise CdprError(
                f"robot '{self.robot.name}' has ideal cables, so there is no winch to export: choose cable.model rigid "
                "or elastic and give the winch, or export without winches"
            )
        return [
            Variable("time", "independent", (), "s", (0.0,), "time"),
            *self._platform(),
            *(self._winches() if self.winches else []),
            *self._inputs(),
            *self._outputs(),
            *self._constants(),
        ]

    def _platform(self) -> list[Variable]:
        robot, state = self.robot, self.state
        platform, m = robot.platform, robot.m
        return [
            _parameter("mass", (), "kg", [platform.mass], "mass of the platform"),
            _parameter(
                "center_of_mass", (3,), "m", platform.center_of_mass, "centre of mass from the origin, platform axes"
            ),
            _parameter("inertia", (3, 3), "kg.m2", platform.inertia, "inertia about the centre of mass, platform axes"),
            _parameter("gravity", (3,), "m/s2", self.gravity, "acceleration of gravity, world axes"),
            _parameter("physics_step", (), "s", [self.physics_step], "step of the integrator"),
            _parameter("frame_anchors", (m, 3), "m", robot.anchors[:, :3], "anchors on the fixed frame, world"),
            _parameter("platform_anchors", (m, 3), "m", robot.anchors[:, 3:], "anchors on the platform, platform axes"),
            _parameter("initial_position", (3,), "m", state[:3], "position of the origin at the start, world"),
            _parameter("initial_quaternion", (4,), "", state[3:7], "attitude at the start, w, x, y, z"),
            _parameter("initial_velocity", (3,), "m/s", state[7:10], "velocity of the origin at the start, world axes"),
            _parameter(
                "initial_angular_velocity", (3,), "rad/s", state[10:], "angular velocity at the start, world axes"
            ),
        ]

    def _winches(self) -> list[Variable]:
        packed, shape = pack(self.robot), (self.robot.m,)
        rows = [
            ("winch.drum_radius", "m", RADIUS, "radius of the drum"),
            ("winch.inertia", "kg.m2", INERTIA, "inertia of motor and drum about the drum's axis"),
            ("winch.viscous_friction", "N.m.s/rad", VISCOUS, "friction torque per drum speed"),
            ("winch.coulomb_friction", "N.m", COULOMB, "friction torque of a drum that turns"),
            ("winch.coulomb_speed", "rad/s", COULOMB_SPEED, "drum speed at which that reaches 76 % of its value"),
        ]
        if self.robot.cable_model == "elastic":
            rows.append(("cable.axial_stiffness", "N", STIFFNESS, "axial stiffness, E A"))
            rows.append(("cable.damping", "N.s/m", DAMPING, "damping along the cable"))
        return [_parameter(name, shape, unit, packed[:, column], text) for name, unit, column, text in rows]

    def _inputs(self) -> list[Variable]:
        m = self.robot.m
        wrench = _input(
            "external_wrench",
            ["N"] * 3 + ["N.m"] * 3,
            "further force (3) and moment (3) on the platform at its origin, world axes",
        )
        pull = (
            _input("command", ["N"] * m, "tension that the motor of each winch would hold at rest")
            if self.winches
            else _input("cable_tension", ["N"] * m, "tension of each cable")
        )
        return [pull, wrench]

    def _outputs(self) -> list[Variable]:
        m = self.robot.m
        outputs = [
            _output("position", 3, "m", "position of the platform's origin, world"),
            _output("quaternion", 4, "", "attitude, platform to world, w, x, y, z"),
            _output("velocity", 3, "m/s", "velocity of the origin, world axes"),
            _output("angular_velocity", 3, "rad/s", "angular velocity, world axes"),
            _output("cable_length", m, "m", "distance between the anchors of each cable"),
            _output("cable_rate", m, "m/s", "rate of change of cable_length"),
        ]
        if not self.winches:
            return outputs
        # The inertia of drums on rigid cables reacts to command and wrench at once.
        rigid = self.robot.cable_model == "rigid"
        outputs.append(_output("cable_tension", m, "N", "tension of each cable", direct=rigid))
        outputs.append(_output("drum_speed", m, "rad/s", "speed of each drum, positive where it winds in"))
        if not rigid:
            outputs.append(_output("unstretched_length", m, "m", "unstretched length between drum and platform"))
        return outputs

    def _constants(self) -> list[Variable]:
        constants = []
        if self.winches:
            pushes = (float(self.robot.unilateral),)
            constants.append(Variable("unilateral", "constant", (), "", pushes, "1 if cables only pull"))
        if self.robot.n < 6:
            guide = tuple(Guide(self.robot).packed.tolist())
            constants.append(Variable("guide", "constant", (6,), "", guide, "free axes (3), axis of the hinge (3)"))
        return constants


def _parameter(
    name: str, shape: tuple[int, ...], unit: str, values: Sequence[float] | Array, description: str
) -> Variable:
    return Variable(name, "parameter", shape, unit, tuple(np.ravel(values).tolist()), description)


def _input(name: str, units: list[str], description: str) -> Variable:
    size = len(units)
    unit = units[0] if len(set(units)) == 1 else tuple(units)
    return Variable(name, "input", (size,), unit, (0.0,) * size, description)


def _output(name: str, size: int, unit: str, description: str, direct: bool = False) -> Variable:
    return Variable(name, "output", (size,), unit, (0.0,) * size, description, direct)
