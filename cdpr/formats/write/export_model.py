"""Data and options of an export: a robot in a state, and properties that formats can represent."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module

import numpy as np

from cdpr.base.errors import FormatError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.cables import chain_of, takes_lengths
from cdpr.formats.write import TARGETS
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.shapes import Box, Cylinder, Mesh, Sphere
from cdpr.scenario import Scenario
from cdpr.scenario.schema import World
from cdpr.simulation.needs import omitted, require

PLATFORM = "#4878a8"  # default colour
FRAME = "#808080"
EDGE = 0.02  # m, radius of the drawn frame bars
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # characters
STEP = 0.001  # s, for a robot without a scenario


@dataclass(frozen=True)
class Subject:
    """Data of an export.

    Attributes:
        robot: the robot; its missing degrees of freedom are guided.
        gravity: (3,), m/s^2, world frame.
        state: (13,), state of the platform's origin, world frame.
        step: physics step, s.
        omitted: what each format of `TARGETS` leaves out of the scenario.
    """

    robot: Robot
    gravity: Array
    state: Array
    step: float
    omitted: Mapping[str, Sequence[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Options:
    """Options of an export.

    Attributes:
        style: of SDF: "platform", a body moved by a wrench, or "legs", cables as legs that push and pull.
        version: of SDF.
        pulleys: of MJCF and SDF: "keep" (rejected if the format does not support them) or "points" (replace them).
    """

    style: str = "platform"
    version: str = "1.9"
    pulleys: str = "keep"


# Allowed values of each option with their descriptions; the first is the default.
CHOICES = {
    "style": {"platform": "pushed by a wrench", "legs": "cables that push and pull"},
    "version": {"1.9": "the present one", "1.6": "for older readers"},
    "pulleys": {
        "keep": "error if unsupported",
        "points": "replaced by points",
    },
}


@dataclass(frozen=True)
class Solid:
    """Shape to draw, with its pose."""

    kind: str  # "box", "sphere" or "cylinder"
    size: tuple[float, ...]  # m: sides; radius; radius and height
    position: Array = field(default_factory=lambda: np.zeros(3))  # m
    attitude: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))


def export(subject: Subject, to: str, options: Options | None = None) -> str:
    """Return a robot as text in a format of `TARGETS`; equal robots give equal texts.

    Args:
        subject: data of the export.
        to: key of `TARGETS`.
        options: options of the export.

    Raises:
        FormatError: if the format is unknown or cannot represent the robot.
    """
    if to not in TARGETS:
        raise FormatError(
            f"to: expected one of {', '.join(TARGETS)}, got {shown(to)}; {did_you_mean(to, TARGETS)}".rstrip("; ")
        )
    given = options or Options()
    for name, known in CHOICES.items():
        if (value := getattr(given, name)) not in list(known):
            raise FormatError(f"{name}: expected one of {', '.join(known)}, got {shown(value)}")
    if given.pulleys == "points":
        cables = tuple(replace(cable, exit=None) for cable in subject.robot.cables)
        subject = replace(subject, robot=replace(subject.robot, cables=cables))
    text: str = import_module(TARGETS[to].module).write(subject, given)
    if wrong := NOT_XML.search(text):
        line = text[: wrong.start()].rpartition("\n")[2].strip()
        raise FormatError(f"{to}: XML cannot contain the character {wrong.group()!r} of a name, after {shown(line)}")
    return text


def left_out(subject: Subject, to: str) -> list[str]:
    """Return parts of cables, guides and scenarios that a format of `TARGETS` omits without an error."""
    wound, rolled = _wound(subject.robot), _rolled(subject.robot)
    floats = subject.robot.n < 6 and not TARGETS[to].guides
    return [
        *([f"the guide that leaves {', '.join(subject.robot.dof)} free: the platform floats there"] if floats else []),
        *([f"winches and elasticity of {', '.join(wound)}"] if wound else []),
        *([f"pulleys of {', '.join(rolled)}: an anchor is where the cable arrives at its pulley"] if rolled else []),
        *subject.omitted.get(to, ()),
    ]


def only_ideal(robot: Robot, what: str) -> None:
    """Raise FormatError if a cable has a winch, elasticity or a pulley, which the format does not support."""
    if wound := _wound(robot):
        changes = ["cable.model=ideal", *(["winch.type=torque"] if takes_lengths(robot) else [])]
        raise FormatError(
            f"robot '{robot.name}': {what} does not support winches and elastic cables: {', '.join(wound)}; to omit "
            f"them, set {' and '.join(each.replace('=', ': ') for each in changes)} "
            f"({' '.join(f'--set robot.{each}' for each in changes)}, of a robot file {' and '.join(changes)})"
        )
    if rolled := _rolled(robot):
        raise FormatError(
            f"robot '{robot.name}': {what} does not support swivelling pulleys: {', '.join(rolled)}; "
            "replace them by points (--pulleys-as-points)"
        )


def _wound(robot: Robot) -> list[str]:
    return [cable.name for cable in robot.cables if not chain_of(robot, cable).immediate]


def _rolled(robot: Robot) -> list[str]:
    return [cable.name for cable in robot.cables if cable.exit is not None and cable.exit.header]


def drawn(robot: Robot) -> Solid:
    """Return the platform's shape, platform axes; a sphere through its anchors if it has none."""
    shape = robot.platform.shape
    if isinstance(shape, Box):
        return Solid("box", shape.size)
    if isinstance(shape, Sphere):
        return Solid("sphere", (shape.radius,))
    if isinstance(shape, Cylinder):
        return Solid("cylinder", (shape.radius, shape.height))
    if isinstance(shape, Mesh):
        low, high = np.array(shape.lower), np.array(shape.upper)
        return Solid("box", tuple((high - low).tolist()), (low + high) / 2)
    radius = float(np.linalg.norm(robot.anchors[:, 3:], axis=1).mean())
    return Solid("sphere", (radius or 0.05,))


def bars(robot: Robot) -> list[Solid]:
    """Return the edges of the frame as cylinders, world frame."""
    if robot.frame is None:
        return []
    found = []
    for row in robot.frame.edges:
        way = row[3:] - row[:3]
        length = float(np.linalg.norm(way))
        if length > 0.0:
            found.append(Solid("cylinder", (EDGE, length), (row[:3] + row[3:]) / 2, _along(way / length)))
    return found


def colour(given: str | None, otherwise: str) -> list[float]:
    """Return red, green, blue and opacity."""
    text = given or otherwise
    return [round(int(text[i : i + 2], 16) / 255, 4) for i in (1, 3, 5)] + [1.0]


def words(values: Sequence[float] | Array) -> str:
    """Return the numbers separated by blanks, each with the shortest exact representation."""
    return " ".join(repr(float(value) + 0.0).removesuffix(".0") for value in values)


def _along(direction: Array) -> Array:
    """Return the shortest rotation, a quaternion (4,), from z to `direction` (3,)."""
    x, y, z = direction.tolist()
    if z < -1.0 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    q = np.array([1.0 + z, -y, x, 0.0])
    return np.asarray(q / np.linalg.norm(q))


def begin(loaded: Scenario | Robot, to: str = "") -> Subject:
    """Return a scenario's robot in its initial state, or a robot at rest at its home.

    Raises:
        ScenarioError: if the format `to`, if given, does not support a section of the scenario.
    """
    if isinstance(loaded, Robot):
        state = np.concatenate([home_pose(loaded)[0], np.zeros(6)])
        return Subject(loaded, np.array(World().gravity), state, STEP)
    if to:
        require(loaded, to)
    gravity, step = np.array(loaded.world.gravity), loaded.simulation.physics_step
    left = {to: omitted(loaded, to) for to in TARGETS}
    return Subject(loaded.robot, gravity, loaded.initial.state(), step, left)
