"""Robot as immutable data. Conventions: see `cdpr.model`."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.base.problems import shown
from cdpr.model.cable import COMMANDED, Cable, CableExit, Winch, given_model
from cdpr.model.frozen import (
    Array,
    Frozen,
    frozen_array,
    given_array,
    given_name,
    given_number,
    given_real,
    read_only,
    shape_of,
)
from cdpr.model.platform import Platform, box_inertia
from cdpr.model.shapes import Frame

__all__ = [
    "COMMANDED",
    "DOF_NAMES",
    "Array",
    "Cable",
    "CableExit",
    "Platform",
    "Robot",
    "Winch",
    "frozen_array",
    "ideal",
    "middle",
    "read_only",
]

# Anchors are at one level if their heights differ by less than this share of their extent.
LEVEL = 0.1

# Quaternions whose norm is 1 up to round-off stay as they are: copies of a robot have the same bits.
ROUND_OFF = 1e-14

DOF_NAMES = ("x", "y", "z", "rx", "ry", "rz")


def middle(anchors: Array, dof: Sequence[str]) -> Array:
    """Return the middle (3,) of anchors (m, 3), m; below them by a quarter of their extent if all are at one level.

    At their level, cables could not lift the platform.
    """
    position: Array = anchors.mean(axis=0)
    extent = float(np.linalg.norm(np.ptp(anchors, axis=0)))
    if "z" in dof and np.ptp(anchors[:, 2]) < LEVEL * extent:
        position[2] -= 0.25 * extent
    return position


def ideal(model: str) -> bool:
    """Return True if tensions of a cable model equal their commands, so that a log needs no separate column."""
    return model == COMMANDED


@dataclass(frozen=True, eq=False, init=False)
class Robot(Frozen):
    """Cable-driven parallel robot: a platform, m cables and n degrees of freedom.

    `Robot.from_points` makes one from arrays, `cdpr.load_robot` from a file, an example or a dict.

    Args:
        platform: moving rigid body.
        cables: the cables; those without a name become cable_1, cable_2, ...
        dof: free directions of the platform, in the order x, y, z, rx, ry, rz.
        name: name.
        unilateral: False for rigid legs, which may also push.
        home: reference pose, (3,) or (7,): position, m, and quaternion w, x, y, z.
        cable_model: default cable model of its cables: see `cdpr.cables`.
        frame: outline of the frame.

    Raises:
        CdprError: if an argument is wrong.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> robot.m, robot.n, robot.anchors.shape
        (8, 6, (8, 6))
        >>> robot.replace(platform=robot.platform.replace(mass=120.0))
        <Robot caroca: 8 cables, 3R3T, platform of 120 kg>
    """

    name: str
    platform: Platform
    cables: tuple[Cable, ...]
    dof: tuple[str, ...]
    unilateral: bool  # False: rigid legs that may also push
    home: Array | None  # (7,) position, m, and quaternion w, x, y, z: reference pose
    cable_model: str  # default cable model of its cables: see `cdpr.cables`
    frame: Frame | None

    def __init__(
        self,
        platform: Platform,
        cables: Sequence[Cable],
        dof: Sequence[str] = DOF_NAMES,
        *,
        name: str = "robot",
        unilateral: bool = True,
        home: ArrayLike | None = None,
        cable_model: str = COMMANDED,
        frame: Frame | None = None,
    ) -> None:
        if not isinstance(platform, Platform):
            raise CdprError(f"Robot(platform=): expected a cdpr.Platform, got {shown(platform)}")
        if frame is not None and not isinstance(frame, Frame):
            raise CdprError(f"Robot(frame=): expected a cdpr.model.Frame, got {shown(frame)}")
        if not isinstance(unilateral, bool):
            raise CdprError(f"Robot(unilateral=): expected True or False, got {shown(unilateral)}")
        vars(self).update(
            name=given_name(name, "Robot(name=)"),
            platform=platform,
            cables=_named(cables, unilateral),
            dof=_directions(dof),
            unilateral=unilateral,
            home=None if home is None else _pose(home, "Robot(home=)"),
            cable_model=given_model(cable_model, "Robot(cable_model=)"),
            frame=frame,
        )

    @classmethod
    def from_points(
        cls,
        frame: ArrayLike,
        platform: ArrayLike,
        *,
        mass: float,
        inertia: ArrayLike | None = None,
        center_of_mass: ArrayLike = (0.0, 0.0, 0.0),
        tension_min: ArrayLike = 0.0,
        tension_max: ArrayLike = math.inf,
        home: ArrayLike | None = None,
        dof: Sequence[str] = DOF_NAMES,
        name: str = "robot",
    ) -> Self:
        """Return a robot from the anchors of its m cables.

        Args:
            frame: A_i, (m, 3), m, world axes.
            platform: B_i, (m, 3), m, platform axes.
            mass: mass of the platform, kg.
            inertia: as for `Platform`; by default that of a solid box around the points of the platform.
            center_of_mass: (3,), m, from the platform's origin, platform axes.
            tension_min: lowest admissible tension, N, a number or (m,).
            tension_max: highest admissible tension, N, a number or (m,).
            home: reference pose, (3,) or (7,); by default upright in the middle of the frame's points,
                lowered by a quarter of their extent if all are at one level, where cables cannot lift.
            dof: free directions of the platform.
            name: name.

        Raises:
            CdprError: if an argument is wrong.

        Example:
            >>> import cdpr
            >>> corners = [[x, y, z] for z in (0.0, 3.0) for x in (-2.0, 2.0) for y in (-2.0, 2.0)]
            >>> points = [[0.05 * x, 0.05 * y, 0.1 - 0.05 * z] for x, y, z in corners]
            >>> robot = cdpr.Robot.from_points(corners, points, mass=20.0)
            >>> robot.home[:3], robot.tension_max[0]
            (array([0. , 0. , 1.5]), np.float64(inf))
        """
        at = "Robot.from_points({}=)".format
        A, B = given_array(frame, (None, 3), at("frame")), given_array(platform, (None, 3), at("platform"))
        if not len(A):
            raise CdprError(f"{at('frame')}: expected at least one point")
        if len(A) != len(B):
            raise CdprError(f"{at('platform')}: expected as many points as frame, {len(A)}, got {len(B)}")
        free = _directions(dof)
        low = _per_cable(tension_min, len(A), at("tension_min"))
        high = _per_cable(tension_max, len(A), at("tension_max"))
        for i in range(len(A)):
            least = given_number(low[i], f"{at('tension_min')}[{i}]")
            given_number(high[i], f"{at('tension_max')}[{i}]", least=least, finite=False)
        if inertia is None:
            inertia = box_inertia(given_number(mass, at("mass"), above=0.0), np.ptp(B, axis=0))
            if not (np.diag(inertia) > 0.0).all():
                if any(each.startswith("r") for each in free):
                    raise CdprError(f"{at('inertia')}: required, because the points of the platform are on one line")
                inertia = np.eye(3)  # has no effect
        body = Platform(mass, inertia, center_of_mass)
        cables = [Cable(a, b, *limits) for a, b, *limits in zip(A, B, low, high, strict=True)]
        return cls(body, cables, dof, name=name, home=middle(A, free) if home is None else home)

    def to_dict(self) -> dict[str, Any]:
        """Return the robot as plain data with the keys of a robot file.

        Raises:
            ScenarioError: if no robot file can describe the robot.
        """
        data: dict[str, Any] = late("Robot.to_dict")(self)
        return data

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the robot as YAML; `cdpr.load_robot` returns an equal robot.

        Raises:
            OutputError: if it cannot be written.
            ScenarioError: if no robot file can describe the robot.
        """
        late("Robot.save")(self, path)

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


def _named(cables: Any, unilateral: bool) -> tuple[Cable, ...]:
    """Return the cables of a robot, all with names."""
    given = list(cables) if isinstance(cables, list | tuple) else []
    wrong = [each for each in given if not isinstance(each, Cable)]
    if wrong or not given:
        raise CdprError(f"Robot(cables=): expected a list of cdpr.Cable, got {shown(wrong[0] if wrong else cables)}")
    named = [each if each.name else each.replace(name=f"cable_{i}") for i, each in enumerate(given, start=1)]
    for i, cable in enumerate(named):
        if unilateral and cable.tension_min < 0.0:
            text = f"tension_min must be at least 0 N, got {cable.tension_min:g}: a cable cannot push"
            raise CdprError(f"Robot(cables=)[{i}]: {text}; rigid legs: unilateral=False")
        if cable.name in (other.name for other in named[:i]):
            raise CdprError(f"Robot(cables=)[{i}]: '{cable.name}' is the name of another cable; names must differ")
    unchanged = type(cables) is tuple and all(map(operator.is_, cables, named))  # loops are reused if it is the same
    return cables if unchanged else tuple(named)


def _directions(dof: Any) -> tuple[str, ...]:
    found = tuple(dof) if isinstance(dof, list | tuple) else ()
    if not found or found != tuple(name for name in DOF_NAMES if name in found):
        raise CdprError(f"Robot(dof=): expected some of {', '.join(DOF_NAMES)}, in this order, got {shown(dof)}")
    return found


def _pose(home: ArrayLike, name: str) -> Array:
    """Return a pose (7,) with a quaternion of norm 1."""
    values = given_real(home, name)
    if values.shape == (3,):
        return frozen_array([*given_array(values, (3,), name), 1.0, 0.0, 0.0, 0.0])
    if values.shape != (7,):
        raise CdprError(f"{name}: expected 3 or 7 numbers, got {shape_of(values)}")
    pose = given_array(values, (7,), name)
    norm = float(np.linalg.norm(pose[3:]))
    if abs(norm - 1.0) <= ROUND_OFF:
        return pose
    if abs(norm - 1.0) > tolerances.UNIT:
        raise CdprError(f"{name}: expected a quaternion of norm 1, got norm {norm:.6g}")
    return frozen_array([*pose[:3], *pose[3:] / norm])


def _per_cable(values: ArrayLike, m: int, name: str) -> list[float]:
    """Return one number per cable, from them or one for all."""
    array = given_real(values, name)
    if array.shape not in ((), (1,), (m,)):
        raise CdprError(f"{name}: expected one number or {m}, one per cable, got {shape_of(array)}")
    return [float(value) for value in np.broadcast_to(array, m)]
