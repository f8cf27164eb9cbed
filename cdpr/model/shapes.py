"""Shapes of platforms and frames, and obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.model.frozen import Frozen


@dataclass(frozen=True)
class Box:
    """Box centred on the platform's origin."""

    size: tuple[float, float, float]  # m, along the platform's axes

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"box": list(self.size)}


@dataclass(frozen=True)
class Sphere:
    """Sphere centred on the platform's origin."""

    radius: float  # m

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"sphere": self.radius}


@dataclass(frozen=True)
class Cylinder:
    """Cylinder centred on the platform's origin, with its axis along the platform's z."""

    radius: float  # m
    height: float  # m

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"cylinder": [self.radius, self.height]}


@dataclass(frozen=True)
class Mesh:
    """Triangle mesh, represented by its bounding box."""

    file: str  # absolute path
    lower: tuple[float, float, float]  # m, corners of the bounding box, platform axes
    upper: tuple[float, float, float]  # m

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"mesh": [list(self.lower), list(self.upper)]}


@dataclass(frozen=True)
class Hull:
    """Convex hull of a mesh."""

    file: str
    corners: tuple[tuple[float, float, float], ...]  # m, as in the file
    dent: float = 0.0  # m, largest depth of the mesh's corners inside the hull

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"hull": [list(corner) for corner in self.corners]}


Shape = Box | Sphere | Cylinder | Mesh


@dataclass(frozen=True, eq=False)
class Obstacle(Frozen):
    """Obstacle for cables; it has no effect on the platform."""

    name: str
    shape: Shape | Hull
    position: NDArray[np.float64]  # (3,), m, world
    attitude: NDArray[np.float64]  # (4,) quaternion w, x, y, z


@dataclass(frozen=True, eq=False)
class Frame(Frozen):
    """Frame that carries the cables' exits."""

    edges: NDArray[np.float64]  # (k, 6): two ends each, m, world
    colour: str | None = None  # "#rrggbb"
