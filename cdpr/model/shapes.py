"""Shapes of platforms and frames, and obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.model.frozen import Frozen, given_array, given_colour, given_name, given_number, given_numbers


@dataclass(frozen=True)
class Box:
    """Box centred on the platform's origin."""

    size: tuple[float, float, float]  # m, along the platform's axes

    def __post_init__(self) -> None:
        size = given_numbers(self.size, 3, "Box(size=)")
        for value in size:
            given_number(value, "Box(size=)", above=0.0)
        vars(self).update(size=size)

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"box": list(self.size)}


@dataclass(frozen=True)
class Sphere:
    """Sphere centred on the platform's origin."""

    radius: float  # m

    def __post_init__(self) -> None:
        vars(self).update(radius=given_number(self.radius, "Sphere(radius=)", above=0.0))

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"sphere": self.radius}


@dataclass(frozen=True)
class Cylinder:
    """Cylinder centred on the platform's origin, with its axis along the platform's z."""

    radius: float  # m
    height: float  # m

    def __post_init__(self) -> None:
        radius = given_number(self.radius, "Cylinder(radius=)", above=0.0)
        vars(self).update(radius=radius, height=given_number(self.height, "Cylinder(height=)", above=0.0))

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

    def __post_init__(self) -> None:
        lower, upper = given_numbers(self.lower, 3, "Mesh(lower=)"), given_numbers(self.upper, 3, "Mesh(upper=)")
        vars(self).update(file=given_name(self.file, "Mesh(file=)"), lower=lower, upper=upper)

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

    def __post_init__(self) -> None:
        corners = given_array(self.corners, (None, 3), "Hull(corners=)")
        vars(self).update(
            file=given_name(self.file, "Hull(file=)"),
            corners=tuple(map(tuple, corners.tolist())),
            dent=given_number(self.dent, "Hull(dent=)", least=0.0),
        )

    @property
    def outline(self) -> dict[str, Any]:
        """Shape as plain data."""
        return {"hull": [list(corner) for corner in self.corners]}


Shape = Box | Sphere | Cylinder | Mesh


@dataclass(frozen=True, eq=False)
class Obstacle(Frozen):
    """Obstacle for cables, and for the platform in a world with contact."""

    name: str
    shape: Shape | Hull
    position: NDArray[np.float64]  # (3,), m, world
    attitude: NDArray[np.float64]  # (4,) quaternion w, x, y, z

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape | Hull):
            raise CdprError(f"Obstacle(shape=): expected a shape such as cdpr.model.Box, got {shown(self.shape)}")
        vars(self).update(
            name=given_name(self.name, "Obstacle(name=)"),
            position=given_array(self.position, (3,), "Obstacle(position=)"),
            attitude=given_array(self.attitude, (4,), "Obstacle(attitude=)"),
        )


@dataclass(frozen=True, eq=False)
class Frame(Frozen):
    """Frame that carries the cables' exits."""

    edges: NDArray[np.float64]  # (k, 6): two ends each, m, world
    colour: str | None = None  # "#rrggbb"

    def __post_init__(self) -> None:
        edges = given_array(self.edges, (None, 6), "Frame(edges=)")
        if not len(edges):
            raise CdprError("Frame(edges=): expected at least one edge")
        vars(self).update(edges=edges, colour=given_colour(self.colour, "Frame(colour=)"))
