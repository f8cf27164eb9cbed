"""What can be exported: a robot, or its winches alone."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr.cables import ACTUATED, MIXED, chain_of, immediate, in_c, model_of, with_model
from cdpr.cables.exit import Exit
from cdpr.errors import CdprError
from cdpr.fmu.export.variables import Model, Variable, entrance, output, parameter
from cdpr.mechanics.guide import Guide
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import Array

COMMAND = "tension that the motor of each winch would hold at rest"
DRUM_SPEED = "speed of each drum, positive where it winds in"
UNSTRETCHED = "unstretched length between drum and platform"

# Parameters of each cable: whose attribute, its name, unit and text.
WINCH = [
    ("winch", "drum_radius", "m", "radius of the drum"),
    ("winch", "inertia", "kg.m2", "inertia of motor and drum about the drum's axis"),
    ("winch", "viscous_friction", "N.m.s/rad", "friction torque per drum speed"),
    ("winch", "coulomb_friction", "N.m", "friction torque of a drum that turns"),
    ("winch", "coulomb_speed", "rad/s", "drum speed at which that reaches 76 % of its value"),
]
ELASTIC = [
    ("cable", "axial_stiffness", "N", "axial stiffness, E A"),
    ("cable", "damping", "N.s/m", "damping along the cable"),
]


@dataclass(frozen=True, eq=False)
class Plant(Model):
    """A robot: the platform on its cables, with all that its motion depends on.

    Attributes:
        gravity: (3,), m/s^2, world.
        state: (13,) initial state, laid out as `cdpr.model` says.
        winches: with the robot's winches, which take commands; without them the plant takes tensions.
    """

    robot: Robot
    gravity: Array
    physics_step: float
    state: Array
    winches: bool = False

    @property
    def name(self) -> str:
        """The robot's."""
        return self.robot.name

    @property
    def description(self) -> str:
        """One line on the robot."""
        robot = self.robot
        return f"cable-driven parallel robot '{robot.name}', {robot.m} cables, moves along {', '.join(robot.dof)}"

    def variables(self) -> list[Variable]:
        """All variables; CdprError where winches are to be exported that the robot does not have."""
        if self.winches and model_of(self.robot) == MIXED:
            raise CdprError(
                f"robot '{self.robot.name}' has cables of different models, and an exported plant knows one for all: "
                "choose one, or export without winches"
            )
        if self.winches and immediate(self.robot):
            raise CdprError(
                f"robot '{self.robot.name}' has ideal cables, so there is no winch to export: choose cable.model rigid "
                "or elastic and give the winch, or export without winches"
            )
        return [
            *_times(self.physics_step),
            *self._platform(),
            *(_winches(self.robot) if self.winches else []),
            *self._inputs(),
            *self._outputs(),
            *self._constants(),
        ]

    def _platform(self) -> list[Variable]:
        robot, state = self.robot, self.state
        platform, m = robot.platform, robot.m
        return [
            parameter("mass", (), "kg", [platform.mass], "mass of the platform"),
            parameter(
                "center_of_mass", (3,), "m", platform.center_of_mass, "centre of mass from the origin, platform axes"
            ),
            parameter("inertia", (3, 3), "kg.m2", platform.inertia, "inertia about the centre of mass, platform axes"),
            parameter("gravity", (3,), "m/s2", self.gravity, "acceleration of gravity, world axes"),
            parameter("frame_anchors", (m, 3), "m", robot.anchors[:, :3], "anchors on the fixed frame, world"),
            parameter("platform_anchors", (m, 3), "m", robot.anchors[:, 3:], "anchors on the platform, platform axes"),
            parameter("initial_position", (3,), "m", state[:3], "position of the origin at the start, world"),
            parameter("initial_quaternion", (4,), "", state[3:7], "attitude at the start, w, x, y, z"),
            parameter("initial_velocity", (3,), "m/s", state[7:10], "velocity of the origin at the start, world axes"),
            parameter(
                "initial_angular_velocity", (3,), "rad/s", state[10:], "angular velocity at the start, world axes"
            ),
        ]

    def _inputs(self) -> list[Variable]:
        m = self.robot.m
        if self.winches:
            pull = entrance("command", m, "N", COMMAND)
        elif self.robot.unilateral:
            pull = entrance("cable_tension", m, "N", "tension of each cable; a negative one counts as 0", least=0.0)
        else:
            pull = entrance("cable_tension", m, "N", "tension of each leg")
        # Two variables, for an array has one unit.
        return [
            pull,
            entrance("external_force", 3, "N", "further force on the platform at its origin, world axes"),
            entrance("external_moment", 3, "N.m", "further moment on the platform, world axes"),
        ]

    def _outputs(self) -> list[Variable]:
        m = self.robot.m
        outputs = [
            output("position", 3, "m", "position of the platform's origin, world"),
            output("quaternion", 4, "", "attitude, platform to world, w, x, y, z"),
            output("velocity", 3, "m/s", "velocity of the origin, world axes"),
            output("angular_velocity", 3, "rad/s", "angular velocity, world axes"),
            output("cable_length", m, "m", "distance between the anchors of each cable"),
            output("cable_rate", m, "m/s", "rate of change of cable_length"),
        ]
        if not self.winches:
            return outputs
        # The inertia of drums on rigid cables reacts to command and wrench at once.
        rigid = not _stretches(self.robot)
        outputs.append(output("cable_tension", m, "N", "tension of each cable", direct=rigid))
        outputs.append(output("drum_speed", m, "rad/s", DRUM_SPEED))
        if not rigid:
            outputs.append(output("unstretched_length", m, "m", UNSTRETCHED))
        return outputs

    def _constants(self) -> list[Variable]:
        constants = [_unilateral(self.robot), *_exits(self.robot)]
        if self.robot.n < 6:
            guide = tuple(Guide(self.robot).packed.tolist())
            constants.append(
                Variable("guide", "constant", (6,), "", guide, "1 along each free axis (3) and about each (3)")
            )
        return constants


@dataclass(frozen=True, eq=False)
class Actuator(Model):
    """The winches of a robot and its elastic cables, without the platform: commands and lengths in, tensions out.

    Lengths and rates are held during a step. Whatever the robot's cable model is, they are elastic.
    """

    robot: Robot
    physics_step: float

    @property
    def name(self) -> str:
        """After the robot's."""
        return f"{self.robot.name} winches"

    @property
    def description(self) -> str:
        """One line on them."""
        return (
            f"winches and elastic cables of the cable-driven parallel robot '{self.robot.name}', {self.robot.m} cables"
        )

    def variables(self) -> list[Variable]:
        """All variables; CdprError where a winch or a stiffness is not known."""
        m = self.robot.m
        home, _ = home_pose(self.robot)
        start = lengths(self.robot, make_state(home[:3], home[3:]))
        return [
            *_times(self.physics_step),
            *_winches(with_model(self.robot, ACTUATED)),
            entrance("command", m, "N", COMMAND),
            entrance("cable_length", m, "m", "distance between the anchors of each cable", start),
            entrance("cable_rate", m, "m/s", "rate of change of cable_length"),
            output("cable_tension", m, "N", "tension of each cable", direct=True),
            output("drum_speed", m, "rad/s", DRUM_SPEED),
            output("unstretched_length", m, "m", UNSTRETCHED),
            _unilateral(self.robot),
        ]


def _times(physics_step: float) -> list[Variable]:
    return [
        Variable("time", "independent", (), "s", (0.0,), "time"),
        parameter("physics_step", (), "s", [physics_step], "step of the integrator"),
    ]


def _stretches(robot: Robot) -> bool:
    return any(chain_of(robot, cable).stretches for cable in robot.cables)


def _winches(robot: Robot) -> list[Variable]:
    for cable in robot.cables:
        chain = chain_of(robot, cable)
        chain.winch.numbers(cable), chain.span.numbers(cable)  # say what is lacking
    known = [*WINCH, *ELASTIC] if _stretches(robot) else WINCH
    owners: dict[str, list[object]] = {"winch": [cable.winch for cable in robot.cables], "cable": list(robot.cables)}
    return [
        parameter(f"{owner}.{name}", (robot.m,), unit, [getattr(each, name) for each in owners[owner]], text)
        for owner, name, unit, text in known
    ]


def _exits(robot: Robot) -> list[Variable]:
    """Kind and numbers of what each cable leaves the frame by, where not all leave at their anchors."""
    given = [cable.exit if isinstance(cable.exit, Exit) and cable.exit.kernels else None for cable in robot.cables]
    if not any(given):
        return []
    kinds: list[type[Exit]] = in_c()
    for cable, each in zip(robot.cables, given, strict=True):
        if each is not None and type(each) not in kinds:
            raise CdprError(f"cable '{cable.name}': exit {each.type} has no C, so it cannot be exported")
    rows = [[0.0] if each is None else [1.0 + kinds.index(type(each)), *each.numbers()] for each in given]
    width = max(map(len, rows))
    values = [value for row in rows for value in row + [0.0] * (width - len(row))]
    return [Variable("exit", "constant", (robot.m, width), "", tuple(values), "kind and numbers, 0 for an anchor")]


def _unilateral(robot: Robot) -> Variable:
    return Variable("unilateral", "constant", (), "", (float(robot.unilateral),), "1 if cables only pull")
