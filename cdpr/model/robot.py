"""Robot as immutable data. Conventions: see `cdpr.model`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.model.frozen import Frozen
from cdpr.model.shapes import Frame, Shape
from cdpr.native.arrays import MASKED, masked

Array = NDArray[np.float64]

COMMANDED = "ideal"  # default cable model, whose tensions equal the commands

DOF_NAMES = ("x", "y", "z", "rx", "ry", "rz")


def frozen_array(values: Sequence[float] | Sequence[Sequence[float]] | Array) -> Array:
    """Return a read-only, C-contiguous float64 copy of `values`.

    Raises:
        CdprError: if some are masked.
    """
    if masked(values):
        raise CdprError(MASKED)
    array = np.array(values, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array


def read_only(array: Array) -> Array:
    """Return a read-only view of `array`."""
    view = array.view()
    view.flags.writeable = False
    return view


def ideal(model: str) -> bool:
    """Return True if tensions of a cable model equal their commands, so that a log needs no separate column."""
    return model == COMMANDED


class CableExit(Protocol):
    """Interface of exits from the frame; see `cdpr.cables`."""

    header: ClassVar[str]

    @property
    def type(self) -> str:
        """Name of its kind in `cdpr.cables`."""

    def numbers(self) -> Sequence[float]:
        """Return the numbers of its kernel."""

    def obstacle(self, frame: Sequence[float], tip: Sequence[float]) -> str:
        """Return why no cable leads from `frame` to `tip`, or ""."""

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return points (k, 3), m, of a line that shows it."""

    def swivel(self) -> Sequence[float] | None:
        """Return the unit vector of the line through the anchor across which the exit point jumps, or None."""


@dataclass(frozen=True)
class Winch:
    """Motor and the drum on which it winds a cable."""

    drum_radius: float = math.nan  # m, unstretched cable per radian; NaN, like the next, without a drum
    inertia: float = math.nan  # kg m^2, of all rotating parts, about the drum's axis
    viscous_friction: float = 0.0  # N m s
    coulomb_friction: float = 0.0  # N m
    coulomb_speed: float = 0.1  # rad/s, speed at which Coulomb friction reaches 76 % (tanh 1) of its value
    own: Mapping[str, float] = field(default_factory=dict)  # additional numbers of its kind of winch, SI units, by key


@dataclass(frozen=True, eq=False)
class Cable(Frozen):
    """Cable between the frame and the platform.

    Optional properties are None if unknown; cable models raise an error if they need one. Named properties are also
    used by solvers and drawings; `own` has those of a single part, by key.
    """

    name: str
    frame: Array  # (3,) A_i, m, world axes
    platform: Array  # (3,) B_i, m, platform axes
    tension_min: float  # N
    tension_max: float  # N
    diameter: float | None = None  # m
    axial_stiffness: float | None = None  # N, the product E A
    damping: float = 0.0  # N s/m, along the cable
    linear_density: float | None = None  # kg/m
    length_min: float | None = None  # m
    length_max: float | None = None  # m
    speed_max: float | None = None  # m/s
    winch: Winch | None = None
    exit: CableExit | None = None  # a point, the anchor, by default
    model: str | None = None  # the robot's cable_model by default
    own: Mapping[str, float] = field(default_factory=dict)  # SI units

    def __repr__(self) -> str:
        return f"<Cable {self.name}: {self.tension_min:g} to {self.tension_max:g} N>"


@dataclass(frozen=True, eq=False)
class Platform(Frozen):
    """Moving rigid body."""

    mass: float  # kg
    inertia: Array  # (3, 3), kg m^2, about the centre of mass, platform axes
    center_of_mass: Array  # (3,), m, from the platform's origin, platform axes
    shape: Shape | None = None
    colour: str | None = None  # "#rrggbb"
    tools: Mapping[str, Array] = field(default_factory=dict)  # points (3,), m, platform axes, by name

    def __repr__(self) -> str:
        return f"<Platform of {self.mass:g} kg>"

    @property
    def outline(self) -> dict[str, Any] | None:
        """Shape as plain data, m: {kind: size}, as in `cdpr.model.shapes`; None if there is none."""
        return None if self.shape is None else self.shape.outline


@dataclass(frozen=True, eq=False)
class Robot(Frozen):
    """Cable-driven parallel robot: a platform, m cables and n degrees of freedom.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> robot.m, robot.n, robot.anchors.shape
        (8, 6, (8, 6))
    """

    name: str
    platform: Platform
    cables: tuple[Cable, ...]
    dof: tuple[str, ...] = DOF_NAMES
    unilateral: bool = True  # False: rigid legs that may also push
    home: Array | None = None  # (7,) position, m, and quaternion w, x, y, z: reference pose
    cable_model: str = COMMANDED  # default cable model of its cables: see `cdpr.cables`
    frame: Frame | None = None

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {self.m} cables, {self.pattern}, platform of {self.platform.mass:g} kg>"

    def _repr_html_(self) -> str:
        """Return the representation in notebooks."""
        html: str = late("Robot._repr_html_")(self)
        return html

    @property
    def m(self) -> int:
        """Number of cables."""
        return len(self.cables)

    @property
    def n(self) -> int:
        """Number of degrees of freedom."""
        return len(self.dof)

    @property
    def rows(self) -> list[int]:
        """Rows of a wrench or twist (6,) for the degrees of freedom."""
        return [DOF_NAMES.index(name) for name in self.dof]

    @property
    def pattern(self) -> str:
        """Motion pattern: 1T, 2T, 3T, 1R2T, 3R3T, ..."""
        turns = sum(name.startswith("r") for name in self.dof)
        return (f"{turns}R" if turns else "") + (f"{self.n - turns}T" if self.n > turns else "")

    @property
    def colours(self) -> dict[str, str]:
        """Colours "#rrggbb" of "platform" and "frame", if given."""
        given = {"platform": self.platform.colour, "frame": self.frame.colour if self.frame else None}
        return {part: colour for part, colour in given.items() if colour is not None}

    @cached_property
    def anchors(self) -> Array:
        """Anchors [A_i, B_i] side by side, (m, 6), m, as used by the kernels."""
        return frozen_array([[*cable.frame, *cable.platform] for cable in self.cables])

    @cached_property
    def tension_min(self) -> Array:
        """Lowest admissible tensions, (m,), N."""
        return frozen_array([cable.tension_min for cable in self.cables])

    @cached_property
    def tension_max(self) -> Array:
        """Highest admissible tensions, (m,), N."""
        return frozen_array([cable.tension_max for cable in self.cables])

    @cached_property
    def characteristic_length(self) -> float:
        """Root mean square of |B_i|, m; 1 if all platform anchors coincide with the origin."""
        length = float(np.sqrt(np.mean(np.sum(self.anchors[:, 3:] ** 2, axis=1))))
        return length if length > 0.0 else 1.0

    @cached_property
    def inertial(self) -> Array:
        """Mass properties for the kernels, (13,): mass, centre of mass (3), inertia tensor row by row."""
        platform = self.platform
        return frozen_array(np.concatenate([[platform.mass], platform.center_of_mass, platform.inertia.ravel()]))
