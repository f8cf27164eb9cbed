"""Distances along rays to obstacles, in closed forms for boxes, spheres, cylinders and convex hulls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.mechanics import solids
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.native.arrays import real
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.sensor import Sources, Truth
from cdpr.tension.operations import Operation

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


def solids_of(obstacles: Sequence[Obstacle]) -> Array:
    """Return the rows of obstacles for the kernels, (s, 11 or more)."""
    return solids.rows([solids.row(each.shape, each.position, tuple(each.attitude.tolist())) for each in obstacles])


def ray_truth(sources: Sources, point: ArrayLike, directions: Array, reach: float) -> Truth:
    """Return the distances along rays from a point of the platform (k,), m.

    Args:
        sources: arrays of the loop.
        point: (3,), m, start of the rays, platform axes.
        directions: (k, 3), of length 1, platform axes.
        reach: distance without a hit, m.
    """
    values, mount = np.zeros(len(directions)), Mount(np.array(point, dtype=float), directions)
    write = bind(
        "cast_rays",
        state=sources.state,
        point=mount.place,
        solids=solids_of(sources.obstacles),
        directions=mount.axes,
        distances=values,
        reach=reach,
    )
    return Truth(values, (Operation("sensors", write),), (values,), mount)


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
