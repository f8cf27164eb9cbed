"""Sections of a robot file."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, Field

from cdpr.base.fields import (
    ZERO,
    Colour,
    Name,
    Number,
    Position,
    Positive,
    Section,
    Vector3,
    tab,
    unit,
)
from cdpr.base.needs import EVERYWHERE, Needs, declared, of_run
from cdpr.cables import (
    ACTUATED,
    COMMANDED,
    MODELS,
    NUMBERS,
    TABLES,
    TORQUE,
    WINCH_TYPES,
    AnyExit,
    composed,
    named,
    names_in_files,
)
from cdpr.cables.chain import Chain
from cdpr.model import Cable, Platform, Robot, Winch
from cdpr.model.robot import Array, frozen_array
from cdpr.scenario.appearance import AT_ORIGIN, FrameSection, ShapeSection
from cdpr.scenario.limits_schema import (
    NO_LENGTH_LIMITS,
    CableTension,
    LengthLimits,
    TensionSection,
    limits,
)
from cdpr.scenario.number_sections import CableNumbers, WinchNumbers
from cdpr.scenario.orientation import UPRIGHT, Orientation
from cdpr.scenario.winch_kinds import driven, unused_numbers

MAX_CABLES = 256
MAX_TOOLS = 64

TRIANGLE_TOLERANCE = 1e-5  # published inertias are rounded: relative to the largest principal moment
DEFINITE_TOLERANCE = 1e-12

CHECKED = "_checked"  # attribute of robots known to be those of a valid file
EXIT = "exit of the cable on the frame; default: a point, its anchor"

if TYPE_CHECKING:
    CableModel = str
    WinchType = str
else:
    CableModel = Literal[tuple(names_in_files())]
    WinchType = Literal[tuple(WINCH_TYPES)]

CABLE_KEYS = tuple(dict.fromkeys(number.file_key for number in NUMBERS.values() if number.owner == "cable"))

DofName = Literal["x", "y", "z", "rx", "ry", "rz"]
ALL_DOF: tuple[DofName, ...] = ("x", "y", "z", "rx", "ry", "rz")
BALL: tuple[DofName, ...] = ("rx", "ry", "rz")
SOUND = "any of x, y, z with at most one of rx, ry, rz; only rx, ry, rz (ball joint at the origin); or all six"
# Moment of inertia, kg m^2, of a platform that does not rotate: required by engines, without effect.
NO_TURNING = 1.0

Inertia = tuple[Number, Number, Number, Number, Number, Number]


def tensor(inertia: Inertia) -> list[list[float]]:
    """Return the 3 x 3 tensor of ixx, iyy, izz, ixy, ixz, iyz (tensor entries, no minus sign)."""
    xx, yy, zz, xy, xz, yz = inertia
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def moments_about(inertia: Inertia) -> tuple[str, ...]:
    """Return the direction of the only nonzero moment, () for zero inertia, else all: planar robots in papers."""
    given = [name for name, value in zip(("rx", "ry", "rz"), inertia, strict=False) if value > 0.0]
    return tuple(given) if len(given) < 2 and sum(map(abs, inertia)) == sum(inertia[:3]) else ("rx", "ry", "rz")


def _possible_inertia(inertia: Inertia) -> Inertia:
    return inertia if len(moments_about(inertia)) < 2 else of_a_body(inertia)  # one may suffice: see the directions


def of_a_body(inertia: Inertia) -> Inertia:
    """Return the inertia; raise ValueError if no rigid body can have it."""
    low, middle, high = np.linalg.eigvalsh(np.array(tensor(inertia)))
    moments = f"its principal moments are {low:.6g}, {middle:.6g}, {high:.6g} kg m^2"
    if low <= DEFINITE_TOLERANCE * abs(high):
        raise ValueError(f"no rigid body has this inertia: {moments}, each must be greater than 0")
    if low + middle < high * (1.0 - TRIANGLE_TOLERANCE):
        raise ValueError(f"no rigid body has this inertia: {moments}, the largest exceeds the sum of the two others")
    return inertia


def names_of_exports(cables: Iterable[str]) -> set[str]:
    """Return the names of frames, links and sites in exports of a robot with these cables."""
    return {"world", "frame", "platform", *(f"{name}_{end}" for name in cables for end in ("frame", "platform"))}


def in_order(dof: tuple[DofName, ...]) -> tuple[DofName, ...]:
    """Return the directions; raise ValueError unless they are unique and in the order of a wrench."""
    if not dof or dof != tuple(name for name in ALL_DOF if name in dof):
        raise ValueError(f"expected each of {', '.join(ALL_DOF)} at most once and in this order, at least one")
    return dof


def _sound_directions(dof: tuple[DofName, ...]) -> tuple[DofName, ...]:
    """Return the directions; raise ValueError unless a guide (slides and a hinge, or a ball) or none allows them."""
    in_order(dof)
    turns = sum(name.startswith("r") for name in dof)
    if turns > 1 and dof not in (BALL, ALL_DOF):
        raise ValueError(f"no guide leaves {', '.join(dof)} free; allowed: {SOUND}")
    return dof


Tools = dict[Name, Position]


class PlatformSection(Section):
    """Moving rigid body."""

    needs: ClassVar[Mapping[str, Needs]] = declared("mass", "inertia", "center_of_mass", "colour", "tools")

    mass: Positive = Field(description="mass of the platform", json_schema_extra=unit("kg"))
    inertia: Annotated[Inertia, AfterValidator(_possible_inertia)] | None = Field(
        None,
        description="ixx, iyy, izz, ixy, ixz, iyz about the centre of mass, platform axes (tensor entries); not "
        "required if the platform does not rotate; moments about held directions have no effect and may all be 0",
        json_schema_extra=unit("kg m^2"),
    )
    center_of_mass: Vector3 = Field(
        ZERO,
        description="centre of mass from the platform's origin, platform axes",
        json_schema_extra=unit("m"),
    )
    shape: ShapeSection | None = Field(
        None, description="for drawing and for `world.contact`: a box, a sphere, a cylinder or a mesh"
    )
    colour: Colour | None = Field(None, description="colour in drawings")
    tools: Tools = Field(
        {},
        max_length=MAX_TOOLS,
        description="points of the platform with a name, such as a nozzle, platform axes; a trajectory may be a tool's",
        json_schema_extra=unit("m"),
    )


class _Typed(Section):
    type: WinchType = Field(
        TORQUE,
        description="command of the winch: a tension (torque), the unwound length (position, stepper), or its rate "
        "(velocity). All but torque require cables that stretch. They follow it exactly; with an `inertia`, position "
        "and velocity are servos, and stepper is a rotor",
    )


class WinchSection(WinchNumbers, _Typed):
    """Motor and drum that wind a cable."""

    needs: ClassVar[Needs] = EVERYWHERE  # the cable's model and its parts declare what they need

    def build(self) -> Winch:
        """Return the winch."""
        return Winch(**_attributes(Winch, self.model_dump(exclude_none=True)))


def _attributes(model: type, values: dict[str, Any]) -> dict[str, Any]:
    """Return keyword arguments for a class of `cdpr.model`; unknown names are collected in `own`."""
    known = {field.name for field in dataclasses.fields(model)}
    own = {key: value for key, value in values.items() if key not in known}
    return {**{key: value for key, value in values.items() if key in known}, "own": own}


class _Modelled(Section):
    model: CableModel = Field(
        COMMANDED,
        description="cable: elastic, heavy (catenary), measured (tabulated), or inextensible, which is rigid if its "
        "winch has an inertia, and otherwise ideal: commands are tensions",
    )


class CablesSection(CableNumbers, _Modelled):
    """Common properties of all cables."""

    needs: ClassVar[Mapping[str, Needs]] = declared("model", *CABLE_KEYS)  # parts of cables declare their own

    exit: AnyExit | None = Field(None, description=EXIT)


class _Spanned(Section):
    name: Name | None = Field(None, description="name of the cable; default: cable_1, cable_2, ...")
    frame: Position = Field(
        description="anchor A_i on the frame, world frame; frame of the robot's base if `frame` is set",
        json_schema_extra=unit("m"),
    )
    platform: Position = Field(description="anchor B_i on the platform, platform axes", json_schema_extra=unit("m"))
    tension: CableTension | None = Field(None, description="limits of this cable alone; default: the robot's")


class CableSection(CableNumbers, _Spanned):
    """Cable between the frame and the platform."""

    needs: ClassVar[Mapping[str, Needs]] = declared("name", "frame", "platform", "model", *CABLE_KEYS) | {
        "speed_max": of_run()
    }

    length: LengthLimits | None = Field(None, description="limits of the cable's length")
    speed_max: Positive | None = Field(None, description="highest winding speed", json_schema_extra=unit("m/s"))
    winch: WinchSection | None = Field(None, description="winch of this cable alone; default: the robot's")
    model: CableModel | None = Field(
        None, description="conversion of this cable's command to its tension; default: that of all cables"
    )
    exit: AnyExit | None = Field(None, description=f"{EXIT}; default: that of all cables")


class Home(Section):
    """Pose at which the robot is described and, by default, where a run starts; relative to the robot's base."""

    needs: ClassVar[Needs] = EVERYWHERE

    position: Position = Field(description="position of the platform's origin", json_schema_extra=unit("m"))
    orientation: Orientation = Field(UPRIGHT, description="attitude; default: upright")


class RobotSection(Section):
    """Cable-driven parallel robot: content of a robot file."""

    needs: ClassVar[Mapping[str, Needs]] = declared("name", "dof", "unilateral")

    name: Name = Field("robot", description="name of the robot; default: the file's name")
    dof: Annotated[tuple[DofName, ...], AfterValidator(_sound_directions)] = Field(
        ALL_DOF,
        description="free directions of the platform, along and about the world's axes; a guide holds the others. "
        f"Allowed: {SOUND}",
        json_schema_extra=tab("robot", 4),
    )
    unilateral: bool = Field(
        True,
        description="cables only pull; false for rigid legs, which may also push",
        json_schema_extra=tab("robot", 4),
    )
    platform: PlatformSection = Field(description="the moving rigid body")
    tension: TensionSection = Field(description="tension limits of all cables")
    frame: FrameSection | None = Field(
        None,
        description="position of the robot's base in the world, and appearance of the frame",
        json_schema_extra=tab("robot", 1),
    )
    home: Home | None = Field(None, description="default pose of analyses and default start of runs")
    cable: CablesSection = Field(
        CablesSection.model_construct(),
        description="common values of all cables; the values of a single cable override them",
        json_schema_extra=tab("robot", 3),
    )
    winch: WinchSection | None = Field(
        None, description="winch of every cable without its own", json_schema_extra=tab("robot", 3)
    )
    cables: list[CableSection] = Field(
        min_length=1, max_length=MAX_CABLES, description="the cables, 256 at most", json_schema_extra=tab("robot", 2)
    )

    def to_robot(self, folder: str = "", like: Robot | None = None) -> Robot:
        """Return the robot; `folder` is the base of its files. All but the platform is that of `like`, if given."""
        if like is not None:
            robot = dataclasses.replace(like, platform=self._platform(folder))
            vars(robot).update({"home": like.home, "anchors": like.anchors, CHECKED: True})  # the same arrays
            return robot
        base = self.frame or AT_ORIGIN
        anchors = base.placed([cable.frame for cable in self.cables])
        robot = Robot(
            name=self.name,
            platform=self._platform(folder),
            cables=tuple(self._cable(i, anchor, base) for i, anchor in enumerate(anchors)),
            dof=self.dof,
            unilateral=self.unilateral,
            home=self._home(),
            cable_model=named(self.cable.model, driven(self.winch)),
            frame=self.frame.build(np.array([cable.frame for cable in self.cables])) if self.frame else None,
        )
        robot.__dict__[CHECKED] = True
        return robot

    def _platform(self, folder: str) -> Platform:
        platform = self.platform
        return Platform(
            mass=platform.mass,
            inertia=self._inertia(),
            center_of_mass=frozen_array(platform.center_of_mass),
            shape=platform.shape.build(folder) if platform.shape else None,
            colour=platform.colour,
            tools={name: frozen_array(point) for name, point in platform.tools.items()},
        )

    def _home(self) -> Array | None:
        """Return the home pose in the world, (7,)."""
        if self.home is None:
            return None
        base = self.frame or AT_ORIGIN
        q = base.turned(self.home.orientation.quaternion())
        return frozen_array([*base.placed(self.home.position), *q])

    def _inertia(self) -> Array:
        """Return the inertia tensor; with at most one nonzero moment, an isotropic one."""
        given = self.platform.inertia or (0.0,) * 6
        one = len(moments_about(given)) < 2
        return frozen_array((sum(given) or NO_TURNING) * np.eye(3) if one else tensor(given))

    def named(self, like: RobotSection | None = None) -> RobotSection:
        """Return the same robot with explicit cable names; if `like` is given, with its cables."""
        if like is not None:
            return self.model_copy(update={"cables": like.cables})
        cables = [cable.model_copy(update={"name": cable_name(cable, i)}) for i, cable in enumerate(self.cables)]
        return self.model_copy(update={"cables": cables})

    def unused(self, actuated: bool = False) -> list[str]:
        """Return the given cable properties that no cable model uses.

        With actuators (`actuated`), all cables use the model of the exported FMU.
        """
        keys = []
        chains = [MODELS[ACTUATED] if actuated else self.chain_of(cable) for cable in self.cables]
        if actuated and any(cable.model not in (None, ACTUATED) for cable in self.cables):
            keys.append("cables[*].model")
        if actuated and self.cable.model not in (COMMANDED, ACTUATED):
            keys.append("cable.model")
        used = {name for chain in chains for number in chain.numbers for name in (number.file_key, number.owner)}
        for name in (*CABLE_KEYS, "winch"):
            if name in used or name == "diameter":  # clearance checks use it in all models
                continue
            if any(getattr(cable, name) is not None for cable in self.cables):
                keys.append(f"cables[*].{name}")
            if name == "winch" and self.winch is not None:
                keys.append(name)
            elif getattr(self.cable, name, None) is not None:
                keys.append(f"cable.{name}")
        return keys if actuated else [*keys, *self._unused_numbers(chains)]

    def _unused_numbers(self, chains: Sequence[Chain]) -> dict[str, None]:
        """Return the given numbers of winches that no cable with this winch uses, such as gains without an inertia."""
        shared = [chain for cable, chain in zip(self.cables, chains, strict=True) if cable.winch is None]
        found = [f"winch.{key}" for key in unused_numbers(self.winch, shared)]
        for cable, chain in zip(self.cables, chains, strict=True):
            found += [f"cables[*].winch.{key}" for key in unused_numbers(cable.winch, [chain])]
        return dict.fromkeys(found)

    def chain_of(self, cable: CableSection) -> Chain:
        """Return winch and span of a cable."""
        winch: WinchSection | None = self._own(cable, "winch")
        return composed(cable.model or self.cable.model, TORQUE if winch is None else winch.type, driven(winch))

    def _model(self, cable: CableSection) -> str | None:
        """Return a cable's own model, None if it has that of all cables."""
        own = named(cable.model or self.cable.model, driven(self._own(cable, "winch")))
        return own if cable.model or own != named(self.cable.model, driven(self.winch)) else None

    def _own(self, cable: CableSection, name: str) -> Any:
        """Return a cable's own value of a shared property, else the common one."""
        own = getattr(cable, name)
        return own if own is not None else self.winch if name == "winch" else getattr(self.cable, name)

    def _cable(self, i: int, anchor: Array, base: FrameSection) -> Cable:
        cable = self.cables[i]
        low, high = limits(self.tension, cable.tension, i)
        length = cable.length or NO_LENGTH_LIMITS
        winch = self._own(cable, "winch")
        given = {key: self._own(cable, key) for key in CABLE_KEYS}
        numbers = {key: value for key, value in given.items() if value is not None}
        numbers |= {k: v for key, table in TABLES.items() for k, v in table.numbers(numbers.pop(key, ())).items()}
        return Cable(
            name=cable_name(cable, i),
            frame=frozen_array(anchor),
            platform=frozen_array(cable.platform),
            tension_min=low,
            tension_max=high,
            length_min=length.min,
            length_max=length.max,
            speed_max=cable.speed_max,
            winch=winch.build() if winch else None,
            exit=base.leaving(self._own(cable, "exit")),
            model=self._model(cable),
            **_attributes(Cable, numbers),
        )


def cable_name(cable: CableSection, i: int) -> str:
    """Return the name of cable i, counted from 0."""
    return cable.name or f"cable_{i + 1}"
