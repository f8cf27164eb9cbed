"""Shapes of platforms and frames, and of what stands in their way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.model.frozen import Frozen


@dataclass(frozen=True)
class Box:
    """A box centred on the platform's origin."""

    size: tuple[float, float, float]  # m, along the platform's axes

    @property
    def outline(self) -> dict[str, Any]:
        """As plain data."""
        return {"box": list(self.size)}


@dataclass(frozen=True)
class Sphere:
    """A sphere centred on the platform's origin."""

    radius: float  # m

    @property
    def outline(self) -> dict[str, Any]:
        """As plain data."""
        return {"sphere": self.radius}


@dataclass(frozen=True)
class Cylinder:
    """A cylinder centred on the platform's origin, its axis along the platform's z."""

    radius: float  # m
    height: float  # m

    @property
    def outline(self) -> dict[str, Any]:
        """As plain data."""
        return {"cylinder": [self.radius, self.height]}


@dataclass(frozen=True)
class Mesh:
    """A mesh of triangles, of which the box around it is drawn."""

    file: str
    lower: tuple[float, float, float]  # m, corners of the box around it, platform axes
    upper: tuple[float, float, float]  # m

    @property
    def outline(self) -> dict[str, Any]:
        """As plain data."""
        return {"mesh": [list(self.lower), list(self.upper)]}


@dataclass(frozen=True)
class Hull:
    """The convex hull of a mesh."""

    file: str
    corners: tuple[tuple[float, float, float], ...]  # m, as the file has them
    dent: float = 0.0  # m, how deep within it corners of the mesh are

    @property
    def outline(self) -> dict[str, Any]:
        """As plain data."""
        return {"hull": [list(corner) for corner in self.corners]}


Shape = Box | Sphere | Cylinder | Mesh


@dataclass(frozen=True, eq=False)
class Obstacle(Frozen):
    """Something that stands in the way of cables; it does not act on the platform."""

    name: str
    shape: Shape | Hull
    position: NDArray[np.float64]  # (3,), m, world
    attitude: NDArray[np.float64]  # (4,) quaternion w, x, y, z


@dataclass(frozen=True, eq=False)
class Frame(Frozen):
    """The frame that carries the cables' exits."""

    edges: NDArray[np.float64]  # (k, 6): two ends each, m, world
    colour: str | None = None  # "#rrggbb"
