"""Cable and its winch as immutable data. Conventions: see `cdpr.model`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Protocol

from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.base.problems import shown
from cdpr.model.frozen import Array, Frozen, FrozenDict, given_array, given_by_key, given_name, given_number

COMMANDED = "ideal"  # default cable model, whose tensions equal the commands
TORQUE = "torque"  # default type of winches


class CableExit(Protocol):
    """Interface of exits from the frame; see `cdpr.cables`."""

    header: ClassVar[str]

    @property
    def type(self) -> str:
        """Name of its kind in `cdpr.cables`."""

    @property
    def rubs(self) -> bool:
        """True if friction changes the tension on it."""

    def damping(self, frame: Sequence[float], tip: Sequence[float]) -> float:
        """Return the damping by friction at rest, per tension, s/m, of a cable from `frame` to `tip`."""

    def numbers(self) -> Sequence[float]:
        """Return the numbers of its kernel."""

    def obstacle(self, frame: Sequence[float], tip: Sequence[float]) -> str:
        """Return why no cable leads from `frame` to `tip`, or ""."""

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return points (k, 3), m, of a line that shows it."""

    def swivel(self) -> Sequence[float] | None:
        """Return the unit vector of the line through the anchor across which the exit point jumps, or None."""


@dataclass(frozen=True, eq=False)
class Winch(Frozen):
    """Motor and the drum on which it winds a cable."""

    drum_radius: float = math.nan  # m, unstretched cable per radian; NaN, like the next, without a drum
    inertia: float = math.nan  # kg m^2, of all rotating parts, about the drum's axis
    viscous_friction: float = 0.0  # N m s
    coulomb_friction: float = 0.0  # N m
    coulomb_speed: float = 0.1  # rad/s, speed at which Coulomb friction reaches 76 % (tanh 1) of its value
    type: str = TORQUE  # quantity that it controls, of `cdpr.cables.WINCH_TYPES`
    own: Mapping[str, float] = field(default_factory=dict)  # additional numbers of its kind of winch, SI units, by key

    def __post_init__(self) -> None:
        values: dict[str, Any] = {}
        for name in ("drum_radius", "inertia", "viscous_friction", "coulomb_friction", "coulomb_speed"):
            value = getattr(self, name)
            unknown = name in ("drum_radius", "inertia") and isinstance(value, float) and math.isnan(value)
            values[name] = float(value) if unknown else given_number(value, f"Winch({name}=)", least=0.0)
        kind = given_name(self.type, "Winch(type=)")
        if kind != TORQUE and kind not in (known := late("names_of_winch_types")()):
            raise CdprError(f"Winch(type=): expected one of {', '.join(known)}, got {shown(kind)}")
        vars(self).update(values, own=_own(self.own, "winch", "Winch(own=)"))


@dataclass(frozen=True, eq=False, init=False)
class Cable(Frozen):
    """Cable between the frame and the platform.

    Optional properties are None if unknown; cable models raise an error if they need one. Named properties are also
    used by solvers and drawings; `own` has those of a single part, by key.

    Args:
        frame: A_i, (3,), m, world axes.
        platform: B_i, (3,), m, platform axes.
        tension_min: lowest admissible tension, N.
        tension_max: highest admissible tension, N; may be infinite.
        name: name; the robot names its cables cable_1, cable_2, ... by default.
        diameter: m.
        axial_stiffness: product E A, N.
        damping: along the cable, N s/m.
        linear_density: kg/m.
        length_min: shortest length, m.
        length_max: longest length, m.
        speed_max: highest winding speed, m/s.
        winch: its winch.
        exit: exit from the frame, of `cdpr.cables`; a point, the anchor, by default.
        model: cable model; the robot's by default.
        own: additional numbers of its cable model, SI units, by key.

    Raises:
        CdprError: if an argument is wrong.

    Example:
        >>> import cdpr
        >>> cdpr.Cable([0.0, 0.0, 3.0], [-0.1, -0.1, 0.0], tension_max=500.0, name="left")
        <Cable left: 0 to 500 N>
    """

    name: str
    frame: Array  # (3,) A_i, m, world axes
    platform: Array  # (3,) B_i, m, platform axes
    tension_min: float  # N
    tension_max: float  # N
    diameter: float | None  # m
    axial_stiffness: float | None  # N, the product E A
    damping: float  # N s/m, along the cable
    linear_density: float | None  # kg/m
    length_min: float | None  # m
    length_max: float | None  # m
    speed_max: float | None  # m/s
    winch: Winch | None
    exit: CableExit | None  # a point, the anchor, by default
    model: str | None  # the robot's cable_model by default
    own: Mapping[str, float]  # SI units

    def __init__(
        self,
        frame: ArrayLike,
        platform: ArrayLike,
        tension_min: float = 0.0,
        tension_max: float = math.inf,
        *,
        name: str = "",
        diameter: float | None = None,
        axial_stiffness: float | None = None,
        damping: float = 0.0,
        linear_density: float | None = None,
        length_min: float | None = None,
        length_max: float | None = None,
        speed_max: float | None = None,
        winch: Winch | None = None,
        exit: CableExit | None = None,
        model: str | None = None,
        own: Mapping[str, float] | None = None,
    ) -> None:
        at = "Cable({}=)".format
        optional = {
            "diameter": diameter,
            "axial_stiffness": axial_stiffness,
            "linear_density": linear_density,
            "length_min": length_min,
            "length_max": length_max,
            "speed_max": speed_max,
        }
        if winch is not None and not isinstance(winch, Winch):
            raise CdprError(f"{at('winch')}: expected a cdpr.model.Winch, got {shown(winch)}")
        if exit is not None and not hasattr(exit, "numbers"):
            raise CdprError(f"{at('exit')}: expected an exit such as cdpr.cables.Pulley, got {shown(exit)}")
        low = given_number(tension_min, at("tension_min"))
        vars(self).update(
            name=given_name(name, at("name")),
            frame=given_array(frame, (3,), at("frame")),
            platform=given_array(platform, (3,), at("platform")),
            tension_min=low,
            tension_max=given_number(tension_max, at("tension_max"), least=low, finite=False),
            damping=given_number(damping, at("damping"), least=0.0),
            winch=winch,
            exit=exit,
            model=None if model is None else given_model(model, at("model")),
            own=_own({} if own is None else own, "cable", at("own")),
            **{
                key: None if value is None else given_number(value, at(key), least=0.0)
                for key, value in optional.items()
            },
        )

    def __repr__(self) -> str:
        return f"<Cable {self.name}: {self.tension_min:g} to {self.tension_max:g} N>"


def given_model(value: Any, name: str) -> str:
    """Return an argument as name of a cable model; raise CdprError with the argument's name unless it is one."""
    model = given_name(value, name)
    if model != COMMANDED and model not in (known := late("names_of_models")()):
        raise CdprError(f"{name}: expected one of {', '.join(known)}, got {shown(value)}")
    return model


def _own(values: Any, owner: str, name: str) -> FrozenDict[float]:
    """Return additional numbers of a cable or winch, by key."""
    if isinstance(values, dict) and not values:
        return FrozenDict()
    known = {field.name for field in fields(Winch if owner == "winch" else Cable)}
    return given_by_key(values, name, [key for key in late("keys_of_numbers")(owner) if key not in known])
