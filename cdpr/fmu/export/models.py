"""Models that can be exported: a robot, or its controller alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import immediate, takes_lengths
from cdpr.cables.motor import motor_table
from cdpr.cables.tables import command_kinds
from cdpr.fmu.export.control import Control
from cdpr.fmu.export.loads import Load, load_variables
from cdpr.fmu.export.parts import add_chains, add_commands, add_lines, winch_parameters
from cdpr.fmu.export.variables import Model, Variable, entrance, output, parameter
from cdpr.fmu.export.winch_variables import (
    COMMANDS,
    PULL,
    START_LENGTH,
    TO_WINCH,
    UNITS,
    UNSTRETCHED,
    all_stretch,
    command_names,
    command_variables,
    has_motors,
    plant_outputs,
    prescribed,
    usual_tension,
    winch_outputs,
)
from cdpr.mechanics.guide import Guide
from cdpr.mechanics.kinematics import lengths
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.exported_pipeline import ExportedPipeline

LENGTH = "distance between the anchors of each cable"
RATE = "rate of change of cable_length"
STATE = (
    ("position", "m", "position of the platform's origin, world"),
    ("quaternion", "", "attitude, platform to world, w, x, y, z"),
    ("velocity", "m/s", "velocity of the origin, world axes"),
    ("angular_velocity", "rad/s", "angular velocity, world axes"),
)
GRAVITY = 9.81  # m/s^2, a typical acceleration


@dataclass(frozen=True, eq=False)
class Plant(Model):
    """Robot: the platform on its cables.

    Attributes:
        gravity: (3,), m/s^2, world.
        state: (13,) initial state, in the layout of `cdpr.model`.
        winches: True with the robot's winches, which take commands; without them the plant takes tensions.
        control: controller inside the FMU; the commands are outputs then.
        loads: bodies that are attached to the platform for some time.
        unwound: (m,), m, unwound lengths at the start for winches that take lengths or rates; None for unstretched
            cables.
    """

    robot: Robot
    gravity: Array
    physics_step: float
    state: Array
    winches: bool = False
    control: Control | None = None
    loads: tuple[Load, ...] = ()
    unwound: Array | None = None

    @property
    def start_lengths(self) -> Array:
        """Return the unwound lengths at the start, m: (m,), 0 for winches that take tensions."""
        given = lengths(self.robot, self.state) if self.unwound is None else self.unwound
        return np.where(command_kinds(self.robot) == 0, 0.0, given)

    @property
    def differentiable(self) -> bool:
        """Return whether directional derivatives are available: not with winches, a controller or loads."""
        return not self.winches and self.control is None and not self.loads

    @property
    def name(self) -> str:
        """Return the name of the robot."""
        return self.robot.name

    @property
    def description(self) -> str:
        """Return one line on the robot."""
        robot = self.robot
        return f"cable-driven parallel robot '{robot.name}', {robot.m} cables, moves along {', '.join(robot.dof)}"

    def variables(self) -> list[Variable]:
        """Return all variables.

        Raises:
            CdprError: if the robot has no winches to export, or the controller uses sensors that the plant lacks.
        """
        if self.winches and immediate(self.robot):
            raise CdprError(
                f"robot '{self.robot.name}' has ideal cables, so there is no winch to export: choose cable.model rigid "
                "or elastic and give the winch, or export without winches"
            )
        if self.control and self.control.measures_winches and not self.winches:
            raise CdprError(
                "the controller uses sensors of the winches (encoders or load cells), which are not exported: add "
                "--with-winch"
            )
        before = [
            *times(self.physics_step),
            *self._platform(),
            *(winch_parameters(self.robot) if self.winches else []),
            *self._start_lengths(),
            *(self.control.parameters() if self.control else []),
            *(self.control.inputs() if self.control else []),
            *self._inputs(),
            *self._outputs(),
        ]
        after = [*self._constants(), *load_variables(self.loads)]
        return [*before, *(self.control.outputs([*before, *after]) if self.control else []), *after]

    def sources(self) -> dict[str, bytes]:
        """Return the sources of the controller."""
        return self.control.sources() if self.control else {}

    def pipeline(self) -> ExportedPipeline:
        """Return the pipeline of cables and controller."""
        pipeline = self.control.copied() if self.control else ExportedPipeline()
        add_lines(pipeline, self.robot)
        if self.winches:
            add_chains(pipeline, self.robot)
            if has_motors(self.robot):
                pipeline.add("motors", motor_table(self.robot), "constant")
        return pipeline

    def _platform(self) -> list[Variable]:
        robot, state = self.robot, self.state
        platform = robot.platform
        return [
            parameter("mass", (), "kg", [platform.mass], "mass of the platform", least=0.0, nominal=platform.mass),
            parameter(
                "center_of_mass", (3,), "m", platform.center_of_mass, "centre of mass from the origin, platform axes"
            ),
            parameter("inertia", (3, 3), "kg.m2", platform.inertia, "inertia about the centre of mass, platform axes"),
            parameter("gravity", (3,), "m/s2", self.gravity, "acceleration of gravity, world axes"),
            *_anchors(robot),
            parameter("initial_position", (3,), "m", state[:3], "position of the origin at the start, world", False),
            parameter("initial_quaternion", (4,), "", state[3:7], "attitude at the start, w, x, y, z", False),
            parameter(
                "initial_velocity", (3,), "m/s", state[7:10], "velocity of the origin at the start, world axes", False
            ),
            parameter(
                "initial_angular_velocity",
                (3,),
                "rad/s",
                state[10:],
                "angular velocity at the start, world axes",
                False,
            ),
        ]

    def _start_lengths(self) -> list[Variable]:
        """Return the unwound lengths at the start: a parameter, unless a controller decides them."""
        if not self.winches or self.control or not takes_lengths(self.robot):
            return []
        return [parameter("initial_unstretched_length", (self.robot.m,), "m", self.start_lengths, START_LENGTH, False)]

    def _commands(self) -> list[Variable]:
        """Return the commands of the winches: inputs, or outputs of a controller."""

        def make(name: str, size: int, kind: str, starts: Array, usual: float | None) -> Variable:
            text, unit = COMMANDS[kind], UNITS[kind]
            if self.control:
                text = f"{text}, as decided; 0 before the first step"
                return output(name, size, unit, text, terminal="winches", nominal=usual)
            return entrance(name, size, unit, text, starts, terminal="winches", nominal=usual)

        return command_variables(self.robot, make, np.where(command_kinds(self.robot) == 1, self.start_lengths, 0.0))

    def _inputs(self) -> list[Variable]:
        m, pulls = self.robot.m, self.robot.unilateral
        most, usual = _strongest(self.robot), usual_tension(self.robot)
        if self.winches:
            pull = self._commands()
        else:
            text = "tension of each cable; a negative one counts as 0" if pulls else "tension of each leg"
            least = 0.0 if pulls else None
            pull = [entrance("cable_tension", m, "N", text, least=least, most=most, nominal=usual, terminal="cables")]
            if self.control:
                pull = [
                    output("cable_tension", m, "N", f"{PULL}, as decided; 0 before the first step", terminal="cables")
                ]
        # Two variables, for an array has one unit.
        further = "further force on the platform at its origin, world axes"
        return [
            *pull,
            entrance("external_force", 3, "N", further, terminal="platform", nominal=_weight(self)),
            entrance("external_moment", 3, "N.m", "further moment on the platform, world axes", terminal="platform"),
        ]

    def _outputs(self) -> list[Variable]:
        robot, m, winches = self.robot, self.robot.m, self.winches
        pose, twist = ("initial_position", "initial_quaternion"), ("initial_velocity", "initial_angular_velocity")
        anchored = (*pose, "frame_anchors", "platform_anchors")
        push = ("external_force", "external_moment")
        required = () if self.control else command_names(self.robot) if winches else ("cable_tension",)
        at_once = winches and all_stretch(self.robot) and not prescribed(self.robot)
        direct = push if at_once else (*required, *push)
        loads = (each.name for each in load_variables(self.loads) if each.causality == "parameter")
        body = ("mass", "center_of_mass", "inertia", "gravity", *loads)
        known = None if winches else (*body, *anchored, *twist, *direct)
        turned, on = "angular acceleration, world axes", "platform"
        outputs = [
            output("position", 3, "m", "position of the platform's origin, world", terminal=on, initial=pose[:1]),
            output("quaternion", 4, "", "attitude, platform to world, w, x, y, z", terminal=on, initial=pose[1:]),
            output("velocity", 3, "m/s", "velocity of the origin, world axes", terminal=on, initial=twist[:1]),
            output("angular_velocity", 3, "rad/s", "angular velocity, world axes", terminal=on, initial=twist[1:]),
            output(
                "acceleration",
                3,
                "m/s2",
                "acceleration of the origin, world axes",
                nominal=GRAVITY,
                terminal=on,
                direct=direct,
                initial=known,
            ),
            output("angular_acceleration", 3, "rad/s2", turned, terminal=on, direct=direct, initial=known),
            output("cable_length", m, "m", LENGTH, least=0.0, initial=anchored, terminal="cables"),
            output("cable_rate", m, "m/s", RATE, initial=(*anchored, *twist), terminal="cables"),
        ]
        if winches:
            decided = self.control is not None
            outputs += [*winch_outputs(robot, (), decided), *plant_outputs(robot, decided)]
        return outputs

    def _constants(self) -> list[Variable]:
        constants = [unilateral(self.robot)]
        if self.robot.n < 6:
            guide = tuple(Guide(self.robot).packed.tolist())
            constants.append(
                Variable("guide", "constant", (6,), "", guide, "1 along each free axis (3) and about each (3)")
            )
        return constants


@dataclass(frozen=True, eq=False)
class Controller(Model):
    """Controller and tension solver without a plant: state and desired motion in, the tension of each cable out."""

    control: Control

    @property
    def robot(self) -> Robot:  # type: ignore[override]
        """Return the robot of the controller."""
        return self.control.robot

    @property
    def physics_step(self) -> float:  # type: ignore[override]
        """Return the step proposed to hosts, s: the control step."""
        return self.control.control_step

    @property
    def name(self) -> str:
        """Return the name, after the robot's."""
        return f"{self.robot.name} controller"

    @property
    def description(self) -> str:
        """Return one line on the controller."""
        names = " with solver ".join(self.control.names)
        return f"controller {names} of the cable-driven parallel robot '{self.robot.name}', {self.robot.m} cables"

    def sources(self) -> dict[str, bytes]:
        """Return the sources of controller and solver."""
        return self.control.sources()

    def pipeline(self) -> ExportedPipeline:
        """Return the pipeline of controller and solver."""
        pipeline = self.control.copied()
        add_lines(pipeline, self.robot)
        add_commands(pipeline, self.robot)
        return pipeline

    def variables(self) -> list[Variable]:
        """Return all variables."""
        robot, control = self.robot, self.control
        state = zip(STATE, np.split(control.desired[:13], [3, 7, 10]), strict=True)
        before = "0 before the first step"
        return [
            Variable("time", "independent", (), "s", (0.0,), "time"),
            *_anchors(robot),
            *control.parameters(),
            *(
                entrance(name, len(start), unit, text, start, terminal="platform")
                for (name, unit, text), start in state
            ),
            *control.inputs(),
            *self._measured(),
            *command_variables(
                robot,
                lambda name, size, kind, _, usual: output(
                    name, size, UNITS[kind], f"commanded {TO_WINCH[kind]}, {before}", terminal="winches", nominal=usual
                ),
                np.zeros(robot.m),
            ),
        ]

    def _measured(self) -> list[Variable]:
        """Return the inputs of measured lengths, which drives by rate need."""
        if not prescribed(self.robot):
            return []
        start = lengths(self.robot, self.control.desired[:13])
        return [entrance("unstretched_length", self.robot.m, "m", UNSTRETCHED, start, least=0.0, terminal="winches")]


def _anchors(robot: Robot) -> list[Variable]:
    m = robot.m
    return [
        parameter("frame_anchors", (m, 3), "m", robot.anchors[:, :3], "anchors on the fixed frame, world"),
        parameter("platform_anchors", (m, 3), "m", robot.anchors[:, 3:], "anchors on the platform, platform axes"),
    ]


def times(physics_step: float) -> list[Variable]:
    """Return the time and the step of the integrator."""
    return [
        Variable("time", "independent", (), "s", (0.0,), "time"),
        parameter("physics_step", (), "s", [physics_step], "step of the integrator", least=0.0, nominal=physics_step),
    ]


def _strongest(robot: Robot) -> float | None:
    """Return the largest tension limit, N; None without limits."""
    most = float(robot.tension_max.max())
    return most if math.isfinite(most) else None


def _weight(plant: Plant) -> float | None:
    """Return the platform's weight, N, as a typical force."""
    return plant.robot.platform.mass * float(np.linalg.norm(plant.gravity)) or None


def unilateral(robot: Robot) -> Variable:
    """Return the constant for cables that only pull."""
    return Variable("unilateral", "constant", (), "", (float(robot.unilateral),), "1 if cables only pull")
