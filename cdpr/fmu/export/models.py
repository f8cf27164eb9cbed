"""Models that can be exported: a robot, its winches alone, or its controller alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import ACTUATED, chain_of, immediate, rubs
from cdpr.cables.chain import Chain
from cdpr.fmu.export.control import Control
from cdpr.fmu.export.loads import Load, load_variables
from cdpr.fmu.export.parts import add_chains, add_lines, winch_parameters
from cdpr.fmu.export.variables import Model, Variable, entrance, output, parameter
from cdpr.mechanics.guide import Guide
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.exported_pipeline import ExportedPipeline

COMMAND = "tension that the motor of each winch would hold at rest"
DRUM_SPEED = "speed of each drum, positive where it winds in"
PULL, LENGTH = "tension of each cable", "distance between the anchors of each cable"
RATE = "rate of change of cable_length"
STATE = (
    ("position", "m", "position of the platform's origin, world"),
    ("quaternion", "", "attitude, platform to world, w, x, y, z"),
    ("velocity", "m/s", "velocity of the origin, world axes"),
    ("angular_velocity", "rad/s", "angular velocity, world axes"),
)
GRAVITY = 9.81  # m/s^2, a typical acceleration
UNSTRETCHED = "unstretched length between drum and platform"


@dataclass(frozen=True, eq=False)
class Plant(Model):
    """Robot: the platform on its cables.

    Attributes:
        gravity: (3,), m/s^2, world.
        state: (13,) initial state, in the layout of `cdpr.model`.
        winches: True with the robot's winches, which take commands; without them the plant takes tensions.
        control: controller inside the FMU; the commands are outputs then.
        loads: bodies that are attached to the platform for some time.
    """

    robot: Robot
    gravity: Array
    physics_step: float
    state: Array
    winches: bool = False
    control: Control | None = None
    loads: tuple[Load, ...] = ()

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
            CdprError: if the robot has no winches to export.
        """
        if self.winches and immediate(self.robot):
            raise CdprError(
                f"robot '{self.robot.name}' has ideal cables, so there is no winch to export: choose cable.model rigid "
                "or elastic and give the winch, or export without winches"
            )
        return [
            *_times(self.physics_step),
            *self._platform(),
            *(winch_parameters(self.robot) if self.winches else []),
            *(self.control.parameters() if self.control else []),
            *(self.control.inputs() if self.control else []),
            *self._inputs(),
            *self._outputs(),
            *self._constants(),
            *load_variables(self.loads),
        ]

    def sources(self) -> dict[str, bytes]:
        """Return the sources of the controller."""
        return self.control.sources() if self.control else {}

    def pipeline(self) -> ExportedPipeline:
        """Return the pipeline of cables and controller."""
        pipeline = self.control.copied() if self.control else ExportedPipeline()
        add_lines(pipeline, self.robot)
        if self.winches:
            add_chains(pipeline, self.robot)
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

    def _inputs(self) -> list[Variable]:
        m, pulls = self.robot.m, self.robot.unilateral
        most, usual = _strongest(self.robot), _usual(self.robot)
        if self.winches:
            pull = entrance("command", m, "N", COMMAND, terminal="winches", nominal=usual)
        else:
            text = "tension of each cable; a negative one counts as 0" if pulls else "tension of each leg"
            least = 0.0 if pulls else None
            pull = entrance("cable_tension", m, "N", text, least=least, most=most, nominal=usual, terminal="cables")
        if self.control:
            text = COMMAND if self.winches else PULL
            pull = output(pull.name, m, "N", f"{text}, as decided; 0 before the first step", terminal=pull.terminal)
        # Two variables, for an array has one unit.
        further = "further force on the platform at its origin, world axes"
        return [
            pull,
            entrance("external_force", 3, "N", further, terminal="platform", nominal=_weight(self)),
            entrance("external_moment", 3, "N.m", "further moment on the platform, world axes", terminal="platform"),
        ]

    def _outputs(self) -> list[Variable]:
        m, winches = self.robot.m, self.winches
        pose, twist = ("initial_position", "initial_quaternion"), ("initial_velocity", "initial_angular_velocity")
        anchored = (*pose, "frame_anchors", "platform_anchors")
        push = ("external_force", "external_moment")
        required = () if self.control else ("command" if winches else "cable_tension",)
        direct = push if winches and _stretching(self.robot) else (*required, *push)
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
        return [*outputs, *(_pulled(self.robot, (), decided=self.control is not None) if winches else [])]

    def _constants(self) -> list[Variable]:
        constants = [_unilateral(self.robot)]
        if self.robot.n < 6:
            guide = tuple(Guide(self.robot).packed.tolist())
            constants.append(
                Variable("guide", "constant", (6,), "", guide, "1 along each free axis (3) and about each (3)")
            )
        return constants


@dataclass(frozen=True, eq=False)
class Actuator(Model):
    """Winches of a robot and its cables, without the platform: commands and lengths in, tensions out.

    Lengths and rates are constant during a step. A cable whose drum moves with it has no tension without the platform.
    """

    robot: Robot
    physics_step: float

    @property
    def name(self) -> str:
        """Return the name, after the robot's."""
        return f"{self.robot.name} winches"

    @property
    def description(self) -> str:
        """Return one line on the winches."""
        return f"winches and cables of the cable-driven parallel robot '{self.robot.name}', {self.robot.m} cables"

    def variables(self) -> list[Variable]:
        """Return all variables.

        Raises:
            CdprError: if winches alone determine no tension, or a parameter of a cable is missing.
        """
        m = self.robot.m
        _require_own_tensions(self.robot)
        home, _ = home_pose(self.robot)
        start = lengths(self.robot, make_state(home[:3], home[3:]))
        return [
            *_times(self.physics_step),
            *winch_parameters(self.robot),
            entrance("command", m, "N", COMMAND, terminal="winches", nominal=_usual(self.robot)),
            entrance("cable_length", m, "m", LENGTH, start, least=0.0, terminal="cables"),
            entrance("cable_rate", m, "m/s", RATE, terminal="cables"),
            *_pulled(self.robot, ("cable_length", "cable_rate")),
            _unilateral(self.robot),
        ]

    def pipeline(self) -> ExportedPipeline:
        """Return the pipeline of winches and spans."""
        pipeline = ExportedPipeline()
        add_chains(pipeline, self.robot)
        return pipeline


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
        return pipeline

    def variables(self) -> list[Variable]:
        """Return all variables."""
        robot, control = self.robot, self.control
        state = zip(STATE, np.split(control.desired[:13], [3, 7, 10]), strict=True)
        description = "commanded tension of each cable, 0 before the first step"
        return [
            Variable("time", "independent", (), "s", (0.0,), "time"),
            *_anchors(robot),
            *control.parameters(),
            *(
                entrance(name, len(start), unit, text, start, terminal="platform")
                for (name, unit, text), start in state
            ),
            *control.inputs(),
            output("command", robot.m, "N", description, terminal="winches", nominal=_usual(robot)),
        ]


def _anchors(robot: Robot) -> list[Variable]:
    m = robot.m
    return [
        parameter("frame_anchors", (m, 3), "m", robot.anchors[:, :3], "anchors on the fixed frame, world"),
        parameter("platform_anchors", (m, 3), "m", robot.anchors[:, 3:], "anchors on the platform, platform axes"),
    ]


def _times(physics_step: float) -> list[Variable]:
    return [
        Variable("time", "independent", (), "s", (0.0,), "time"),
        parameter("physics_step", (), "s", [physics_step], "step of the integrator", least=0.0, nominal=physics_step),
    ]


def _chains(robot: Robot) -> list[Chain]:
    return [chain_of(robot, cable) for cable in robot.cables]


def _require_own_tensions(robot: Robot) -> None:
    """Reject cables whose tension depends on the platform's acceleration, and a robot without any winch."""
    if immediate(robot):
        raise CdprError(
            f"robot '{robot.name}' has ideal cables, so there is no winch to export: set cable.model to {ACTUATED} and "
            "give winch and stiffness, or export the robot without winches"
        )
    if rubs(robot):
        raise CdprError(
            f"robot '{robot.name}' has pulleys with friction: their wrap angles depend on the platform, which winches "
            "alone do not know: remove the friction, or export winches and platform in one, with --with-winch"
        )
    for cable, chain in zip(robot.cables, _chains(robot), strict=True):
        if chain.span.bends:
            raise CdprError(
                f"cable '{cable.name}' has model {cable.model or robot.cable_model}: it sags, so its tension depends "
                "on the direction of its chord, and winches alone know only its length: set its model to "
                f"{ACTUATED}, or export winches and platform in one, with --with-winch"
            )
        if not (chain.stretches or chain.immediate):
            raise CdprError(
                f"cable '{cable.name}' has model {cable.model or robot.cable_model}: it does not stretch, so its drum "
                "moves with the platform, so winches alone do not determine its tension: set its model to "
                f"{ACTUATED}, or export winches and platform in one, with --with-winch"
            )


def _stretching(robot: Robot) -> bool:
    return all(chain.stretches for chain in _chains(robot))


def _strongest(robot: Robot) -> float | None:
    """Return the largest tension limit, N; None without limits."""
    most = float(robot.tension_max.max())
    return most if math.isfinite(most) else None


def _usual(robot: Robot) -> float | None:
    """Return half of that as a typical tension, N."""
    most = _strongest(robot)
    return 0.5 * most if most else None


def _weight(plant: Plant) -> float | None:
    """Return the platform's weight, N, as a typical force."""
    return plant.robot.platform.mass * float(np.linalg.norm(plant.gravity)) or None


def _pulled(robot: Robot, lengths: Sequence[str], decided: bool = False) -> list[Variable]:
    """Return the outputs of cables on winches; `lengths` are the inputs that replace the platform, if there is none."""
    chains = _chains(robot)
    # The inertia of backdriven drums responds to command and wrench at once, and so do ideal cables to commands.
    at_once = lengths if _stretching(robot) else ("external_force", "external_moment") if decided else None
    usual = _usual(robot)
    outputs = [
        output("cable_tension", robot.m, "N", PULL, direct=at_once, nominal=usual, terminal="cables"),
        output("drum_speed", robot.m, "rad/s", DRUM_SPEED, terminal="winches", direct=_passed(chains, lengths)),
    ]
    if any(chain.stretches for chain in chains):
        passed = _passed(chains, lengths)
        outputs.append(
            output("unstretched_length", robot.m, "m", UNSTRETCHED, least=0.0, terminal="winches", direct=passed)
        )
    return outputs


def _passed(chains: Sequence[Chain], lengths: Sequence[str]) -> Sequence[str]:
    """Return outputs that repeat the inputs lengths and rates for cables that do not stretch."""
    return () if all(chain.stretches for chain in chains) else lengths


def _unilateral(robot: Robot) -> Variable:
    return Variable("unilateral", "constant", (), "", (float(robot.unilateral),), "1 if cables only pull")
