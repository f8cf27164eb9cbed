"""Sections of a robot file on appearance, obstacles and the pose of its base."""

from __future__ import annotations

import os
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from cdpr.base.fields import ZERO, Colour, Coordinate, Position, Positive, Section, unit
from cdpr.base.needs import EVERYWHERE, Needs, left_out, of_run
from cdpr.cables.exit import Exit
from cdpr.model import rotations
from cdpr.model.robot import Array, frozen_array
from cdpr.model.shapes import Box, Cylinder, Frame, Hull, Mesh, Obstacle, Shape, Sphere
from cdpr.scenario.mesh import ENDINGS, box_around, hull_of
from cdpr.scenario.orientation import UPRIGHT, Orientation

CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
# Pairs of corners that differ in one coordinate; posts differ in z.
EDGES = [(i, j) for i in range(8) for j in range(i + 1, 8) if np.abs(CORNERS[i] - CORNERS[j]).sum() == 1.0]
POSTS = [(i, j) for i, j in EDGES if CORNERS[i, 2] != CORNERS[j, 2]]

Edge = tuple[Coordinate, Coordinate, Coordinate, Coordinate, Coordinate, Coordinate]
MAX_EDGES = 4096

UNDRAWN = left_out("not exported")


class CylinderSection(Section):
    """Cylinder along z."""

    needs: ClassVar[Needs] = EVERYWHERE
    radius: Positive = Field(description="radius", json_schema_extra=unit("m"))
    height: Positive = Field(description="height, half of it above the platform's origin", json_schema_extra=unit("m"))


class ShapeSection(Section):
    """Shape of the platform, for drawing; it has no effect on the motion."""

    needs: ClassVar[Needs] = EVERYWHERE
    box: tuple[Positive, Positive, Positive] | None = Field(
        None,
        description="size of a box along the platform's axes, centred on its origin",
        json_schema_extra=unit("m"),
    )
    sphere: Positive | None = Field(
        None, description="radius of a sphere centred on the platform's origin", json_schema_extra=unit("m")
    )
    cylinder: CylinderSection | None = Field(None, description="a cylinder centred on the platform's origin")
    mesh: str | None = Field(
        None,
        min_length=1,
        description=f"name of a file ({', '.join(ENDINGS)}) relative to this one: triangles in metres, platform axes; "
        "of it the box around it is drawn",
    )

    @model_validator(mode="after")
    def _one_form(self) -> ShapeSection:
        if len(self.model_fields_set) != 1 or self.given is None:
            raise ValueError(f"expected exactly one of {', '.join(type(self).model_fields)}")
        return self

    @property
    def given(self) -> Any:
        """The given form."""
        return next((value for value in dict(self).values() if value is not None), None)

    def build(self, folder: str) -> Shape:
        """Return the shape.

        Raises:
            UnreadableError: if a mesh in `folder` cannot be read.
        """
        if self.box is not None:
            return Box(self.box)
        if self.sphere is not None:
            return Sphere(self.sphere)
        if self.cylinder is not None:
            return Cylinder(self.cylinder.radius, self.cylinder.height)
        assert self.mesh is not None
        path = os.path.join(folder, self.mesh)
        above, name = os.path.split(path)  # `..` refers to the parent of a link's target
        return Mesh(os.path.join(os.path.realpath(above), name), *box_around(path))


class ObstacleSection(Section):
    """Obstacle that cables should not touch: workspaces and runs check it. The platform touches it with `contact`."""

    needs: ClassVar[Needs] = of_run(mjcf=UNDRAWN, sdf=UNDRAWN, urdf=UNDRAWN)
    name: str | None = Field(None, min_length=1, description="name; default: obstacle 1, obstacle 2, ...")
    box: tuple[Positive, Positive, Positive] | None = Field(
        None, description="size of a box along its axes, about its middle", json_schema_extra=unit("m")
    )
    sphere: Positive | None = Field(None, description="radius of a sphere", json_schema_extra=unit("m"))
    cylinder: CylinderSection | None = Field(None, description="a cylinder about its middle")
    mesh: str | None = Field(
        None,
        min_length=1,
        description=f"name of a file ({', '.join(ENDINGS)}) relative to this one: triangles in metres, its own axes; "
        "its convex hull counts",
    )
    position: Position = Field(
        description="position of its middle, for a mesh of the origin of its axes, world", json_schema_extra=unit("m")
    )
    orientation: Orientation = Field(UPRIGHT, description="its attitude; default: upright")

    @model_validator(mode="after")
    def _one_form(self) -> ObstacleSection:
        forms = ("box", "sphere", "cylinder", "mesh")
        if sum(getattr(self, name) is not None for name in forms) != 1:
            raise ValueError(f"expected exactly one of {', '.join(forms)}")
        return self

    def build(self, number: int, folder: str) -> Obstacle:
        """Return the obstacle, the `number`-th starting at 1.

        Raises:
            UnreadableError: if a mesh in `folder` cannot be read.
        """
        shape: Shape | Hull
        if self.box is not None:
            shape = Box(self.box)
        elif self.sphere is not None:
            shape = Sphere(self.sphere)
        elif self.cylinder is not None:
            shape = Cylinder(self.cylinder.radius, self.cylinder.height)
        else:
            assert self.mesh is not None
            shape = Hull(self.mesh, *hull_of(os.path.join(folder, self.mesh)))
        place, attitude = frozen_array(self.position), frozen_array(self.orientation.quaternion())
        return Obstacle(self.name or f"obstacle {number}", shape, place, attitude)


class FrameSection(Section):
    """Frame: pose of the base, to which the anchors A_i and the home pose refer, and its outline for drawing."""

    needs: ClassVar[Needs] = EVERYWHERE
    position: Position = Field(
        ZERO,
        description="position of the robot's base: the frame anchors of the cables and the home pose are given from it",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(UPRIGHT, description="attitude of that base; default: upright")
    shape: Literal["box", "posts"] = Field("box", description="drawn edges: all of a box, or the upright ones")
    lower: Position | None = Field(
        None,
        description="lowest corner of that box, axes of the base; default: that of the box around its plane z = 0 and "
        "all frame anchors",
        json_schema_extra=unit("m"),
    )
    upper: Position | None = Field(
        None, description="highest corner of that box, likewise", json_schema_extra=unit("m")
    )
    edges: Annotated[list[Edge], Field(min_length=1, max_length=MAX_EDGES)] | None = Field(
        None,
        description="drawn edges instead of those of a box: two ends each, x, y, z and x, y, z, axes of the base",
        json_schema_extra=unit("m"),
    )
    colour: Colour | None = Field(None, description="colour in drawings")

    @model_validator(mode="after")
    def _ordered(self) -> FrameSection:
        if self.edges is not None and (self.lower is not None or self.upper is not None or self.shape != "box"):
            raise ValueError("expected either edges, or shape, lower and upper")
        if self.lower is not None and self.upper is not None:
            for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
                if low > high:
                    raise ValueError(f"{axis} of lower ({low:g} m) must not exceed that of upper ({high:g} m)")
        return self

    @property
    def attitude(self) -> Array:
        """Attitude of the base as quaternion w, x, y, z, (4,)."""
        return self.orientation.quaternion()

    @property
    def moved(self) -> bool:
        """True if the base does not coincide with the world frame."""
        if self.orientation is UPRIGHT:  # default value; checked first, because each cable calls this
            return self.position != ZERO
        return self.position != ZERO or self.attitude.tolist() != [1.0, 0.0, 0.0, 0.0]

    def placed(self, points: Any) -> Array:
        """Return points (..., 3), m, from base to world coordinates."""
        here = np.array(points, dtype=np.float64)
        if not self.moved:
            return here
        R = rotations.matrix(self.attitude)
        turned = [here[..., j, None] * R[:, j] for j in range(3)]  # no matmul: its rounding depends on the machine
        return turned[0] + turned[1] + turned[2] + self.position

    def turned(self, attitude: Array) -> Array:
        """Return an attitude (4,) relative to the base, in the world."""
        return rotations.multiply(self.attitude, attitude) if self.moved else attitude

    def leaving(self, exit_: Exit | None) -> Exit | None:
        """Return an exit in base axes, in world axes."""
        return exit_.turned(rotations.matrix(self.attitude)) if exit_ and self.moved else exit_

    def build(self, anchors: Array) -> Frame:
        """Return the frame around anchors (m, 3), relative to the base."""
        if self.edges is not None:
            return Frame(self.placed(np.array(self.edges).reshape(-1, 3)).reshape(-1, 6), self.colour)
        low, high = anchors.min(axis=0), anchors.max(axis=0)
        low[2], high[2] = min(low[2], 0.0), max(high[2], 0.0)
        low = low if self.lower is None else np.array(self.lower)
        high = high if self.upper is None else np.array(self.upper)
        corners = self.placed(low + CORNERS * (high - low))
        pairs = EDGES if self.shape == "box" else POSTS
        return Frame(frozen_array([[*corners[i], *corners[j]] for i, j in pairs]), self.colour)


AT_ORIGIN = FrameSection.model_construct(set(), orientation=UPRIGHT)  # default frame
