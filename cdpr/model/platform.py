"""Platform as immutable data, and the inertia of a box. Conventions: see `cdpr.model`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.model.frozen import (
    Array,
    Frozen,
    FrozenDict,
    frozen_array,
    given_array,
    given_colour,
    given_name,
    given_number,
    given_real,
    shape_of,
)
from cdpr.model.shapes import Shape


@dataclass(frozen=True, eq=False, init=False)
class Platform(Frozen):
    """Moving rigid body.

    Args:
        mass: kg.
        inertia: (3, 3), kg m^2, about the centre of mass, platform axes; or ixx, iyy, izz; or ixx, iyy, izz, ixy, ixz,
            iyz (tensor entries).
        center_of_mass: (3,), m, from the platform's origin, platform axes.
        shape: shape for drawing, of `cdpr.model`.
        colour: "#rrggbb" or a basic name such as "red".
        tools: points (3,), m, platform axes, by name.

    Raises:
        CdprError: if an argument is wrong.

    Example:
        >>> import cdpr
        >>> platform = cdpr.Platform(mass=20.0, inertia=[0.5, 0.5, 0.8])
        >>> platform.inertia.shape
        (3, 3)
    """

    mass: float  # kg
    inertia: Array  # (3, 3), kg m^2, about the centre of mass, platform axes
    center_of_mass: Array  # (3,), m, from the platform's origin, platform axes
    shape: Shape | None
    colour: str | None  # "#rrggbb"
    tools: Mapping[str, Array]  # points (3,), m, platform axes, by name

    def __init__(
        self,
        mass: float,
        inertia: ArrayLike,
        center_of_mass: ArrayLike = (0.0, 0.0, 0.0),
        *,
        shape: Shape | None = None,
        colour: str | None = None,
        tools: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        if tools is not None and not isinstance(tools, Mapping):
            raise CdprError(f"Platform(tools=): expected points by name, got {type(tools).__name__}")
        if shape is not None and not isinstance(shape, Shape):
            raise CdprError(f"Platform(shape=): expected a shape such as cdpr.model.Box, got {type(shape).__name__}")
        vars(self).update(
            mass=given_number(mass, "Platform(mass=)", above=0.0),
            inertia=inertia_tensor(inertia, "Platform(inertia=)"),
            center_of_mass=given_array(center_of_mass, (3,), "Platform(center_of_mass=)"),
            shape=shape,
            colour=given_colour(colour, "Platform(colour=)"),
            tools=FrozenDict(
                {
                    given_name(key, "Platform(tools=)"): given_array(point, (3,), f"Platform(tools=)[{key!r}]")
                    for key, point in (tools or {}).items()
                }
            ),
        )

    def __repr__(self) -> str:
        return f"<Platform of {self.mass:g} kg>"

    @property
    def outline(self) -> dict[str, Any] | None:
        """Shape as plain data, m: {kind: size}, as in `cdpr.model.shapes`; None if there is none."""
        return None if self.shape is None else self.shape.outline


def inertia_tensor(inertia: ArrayLike, name: str) -> Array:
    """Return a symmetric inertia tensor (3, 3) from it, its diagonal, or its six different entries.

    Raises:
        CdprError: with the argument's name, if it has another shape or is not symmetric.
    """
    array = inertia if isinstance(inertia, np.ndarray) else given_real(inertia, name)
    if array.shape == (3,):
        return frozen_array(np.diag(given_array(array, (3,), name)))
    if array.shape == (6,):
        xx, yy, zz, xy, xz, yz = given_array(array, (6,), name)
        return frozen_array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if array.shape != (3, 3):
        raise CdprError(f"{name}: expected 3 x 3, 3 or 6 numbers, got {shape_of(array)}")
    tensor = given_array(array, (3, 3), name)
    if not np.array_equal(tensor, tensor.T):
        raise CdprError(f"{name}: expected a symmetric tensor")
    return tensor


def box_inertia(mass: float, size: Array) -> Array:
    """Return the inertia (3, 3), kg m^2, of a solid box of these sides (3,), m, about its centre."""
    x, y, z = (size**2).tolist()
    return np.diag([mass * (y + z) / 12.0, mass * (x + z) / 12.0, mass * (x + y) / 12.0])
