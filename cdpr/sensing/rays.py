"""Distances along rays to obstacles, in closed forms for boxes, spheres, cylinders and convex hulls."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from cdpr.base.errors import CdprError
from cdpr.base.fields import ZERO, Position, Positive, unit
from cdpr.mechanics import solids
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.native.arrays import real
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import Errors
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Sensor, Sources, Truth
from cdpr.tension.operations import Operation

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing

MOST_DRAWN = 61  # rays of a sensor
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


def solids_of(obstacles: Sequence[Obstacle]) -> Array:
    """Return the rows of obstacles for the kernels, (s, 11 or more)."""
    return solids.rows([solids.row(each.shape, each.position, tuple(each.attitude.tolist())) for each in obstacles])


class RaySensor(Sensor):
    """Base class of sensors of the distances to obstacles along rays from a point of the platform."""

    mount: ClassVar[tuple[str, ...]] = ("place", "axes")
    sees_obstacles: ClassVar[bool] = True
    not_estimated: ClassVar[str] = (
        "distances to obstacles need a map of the hall, which the nominal robot does not have"
    )

    point: Position = Field(ZERO, description="start of the rays, platform axes", json_schema_extra=unit("m"))
    reach: Positive = Field(10.0, description="distance without an obstacle", json_schema_extra=unit("m"))
    distance: Errors = Field(Errors(), description="errors of the distances, m")

    @property
    @abstractmethod
    def directions(self) -> Array:
        """Unit vectors along the rays (k, 3), platform axes."""

    @property
    def reach_limit(self) -> float:
        """Distance without an obstacle, m."""
        return self.reach

    def truth(self, sources: Sources) -> Truth:
        """Return the distances (k,)."""
        directions = self.directions
        values, mount = np.zeros(len(directions)), Mount(np.array(self.point), directions)
        write = bind(
            "cast_rays",
            state=sources.state,
            point=mount.place,
            solids=solids_of(sources.obstacles),
            directions=mount.axes,
            distances=values,
            reach=self.reach,
        )
        return Truth(values, (Operation("sensors", write),), (values,), mount)

    def drawing(self, extent: float) -> SensorDrawing:
        """Return the rays, of many only some."""
        from cdpr.scene.sensors import SensorDrawing  # validation needs no drawings

        rays = self.directions
        few = np.unique(np.rint(np.linspace(0, len(rays) - 1, min(len(rays), MOST_DRAWN))).astype(int))
        place, column = np.array(self.point), f"{self.title}_distance"
        return SensorDrawing(self.title, True, place, rays=rays[few], column=column, chosen=tuple(few.tolist()))

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return the distances."""
        if records.solids is None:
            return None
        rays = self.directions
        state, found, out = np.zeros(13), np.zeros(len(rays)), np.empty((len(records.state), len(rays)))
        about = {"state": state, "point": np.array(self.point), "solids": records.solids}
        cast = bind("cast_rays", **about, directions=rays, distances=found, reach=self.reach)
        for state[:], distances in zip(records.state, out, strict=True):
            cast()
            distances[:] = found
        return out


def echoes(distances: Array, reach: float) -> Array:
    """Return distances with infinity for those without an obstacle, as REP 117 of ROS requires."""
    return np.where(distances >= reach, np.inf, distances)


def ray_distances(obstacles: Sequence[Obstacle], start: ArrayLike, directions: ArrayLike, reach: float) -> Array:
    """Return the distance to the nearest obstacle along each ray (k,), m; 0 if the start is in an obstacle.

    Args:
        obstacles: obstacles.
        start: (3,), m, world axes.
        directions: (k, 3), world axes, of any length.
        reach: distance without a hit, m.

    Raises:
        CdprError: if an array has another shape, or a direction no length.

    Example:
        >>> from cdpr.model.shapes import Obstacle, Sphere
        >>> ball = Obstacle("ball", Sphere(0.5), [2.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
        >>> ray_distances([ball], [0.0, 0.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 10.0)
        array([ 1.5, 10. ])
    """
    point, rays = real(start, "start"), real(directions, "directions")
    if point.shape != (3,) or rays.ndim != 2 or rays.shape[1] != 3:
        raise CdprError(f"expected a start (3,) and directions (k, 3), got shapes {point.shape} and {rays.shape}")
    sizes = np.linalg.norm(rays, axis=1)
    if not (sizes > 0.0).all():
        raise CdprError("directions: expected finite vectors that are not 0")
    state, found = np.zeros(13), np.zeros(len(rays))
    state[:7] = UPRIGHT
    bind(
        "cast_rays",
        state=state,
        point=point,
        solids=solids_of(obstacles),
        directions=rays / sizes[:, None],
        distances=found,
        reach=float(reach),
    )()
    return found
