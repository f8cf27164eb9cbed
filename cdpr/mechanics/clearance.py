"""Clearances between cables, and of cables from their own platform and from obstacles.

The axis of a cable is the segment from its exit point on the frame to its anchor on the platform. The axis of a cable
that sags is its curve if its unwound length is known (`Clearance.at`). The clearance of two cables is the distance of
their axes minus both radii. The clearance of a cable from a solid is the distance of its axis minus its radius. A
negative clearance means interference.

- Two cables share an anchor if their anchors on one side are closer than the sum of their radii. They always touch at
  this anchor, and elsewhere only if they are almost parallel. The clearance of such a pair uses the distance of the
  other end of each cable from the other cable. Cables that are this close on both sides, but not in identical points,
  touch along their whole length.
- The platform is a convex solid. A cable whose anchor lies on its surface passes through it if the other end of the
  cable is below all faces on which the anchor lies (the tangent cone). The clearance is then the height of this end
  above the highest of these faces. The clearance of a cable with an anchor outside the solid is its distance from the
  solid. An anchor inside the solid gives no clearance, because the solid does not represent the platform there.
- A curve passes through the platform if its tangent at the anchor does, or if it enters the solid farther on. In the
  first case, the point of the tangent at the distance of the other end takes the place of this end.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.base.threads import in_threads
from cdpr.cables import bends
from cdpr.cables.tables import chain_table, line_table
from cdpr.mechanics import solids
from cdpr.mechanics.contacts import PLATFORM
from cdpr.mechanics.distances import solid_distances
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.native.bind import bind

# Largest distance of an anchor from the surface of its platform at which it is on the surface [m]. It is less than the
# thickness of cables and more than the rounding of coordinates in files.
ON_SURFACE = 1e-5

# Kinds of clearance of a pair of cables, as in clearance.hpp.
APART, SHARED, SAME = range(3)

# Radius of a broken cable: its clearance is infinite.
GONE = -math.inf


class Bodies(NamedTuple):
    """Bodies and pairs that may touch, in the layout of the kernel library (clearance.hpp)."""

    lines: Array  # (m, w) table of `cdpr.cables.tables.line_table`
    radius: Array  # (m,) radii [m], GONE for a broken cable
    pairs: NDArray[np.int64]  # (m, m) APART, SHARED or SAME
    platform: Array  # (0 or 1, 11) row of `cdpr.mechanics.solids`, platform axes
    obstacles: Array  # (k, 11 or more) rows in the world frame


@dataclass(frozen=True, eq=False)
class Clearance:
    """Clearances of the cables of a robot.

    Attributes:
        robot: robot with the cables.
        obstacles: obstacles in the world.
        bodies: cables, platform and obstacles in the layout of the kernels.
        sharing: names of the pairs of cables that share an anchor.
        unjudged: names of the cables whose anchor is inside the platform's shape; all cables if it has no shape.
        gravity: (3,) m/s^2, world axes, for the curves of cables that sag; None if unknown.
    """

    robot: Robot
    obstacles: tuple[Obstacle, ...]
    bodies: Bodies
    sharing: tuple[tuple[str, str], ...]
    unjudged: tuple[str, ...]
    gravity: Array | None = None

    @cached_property
    def sagging(self) -> dict[str, Any]:
        """Arguments of the kernels for the curves of cables that sag; empty without such cables or gravity."""
        if self.gravity is None or not bends(self.robot):
            return {}
        return {"chains": chain_table(self.robot), "gravity": self.gravity}

    def at(
        self, poses: ArrayLike, jobs: int | None = None, *, unwound: ArrayLike | None = None
    ) -> tuple[Array, NDArray[np.int64]]:
        """Compute the least clearance at each of many poses.

        Args:
            poses: (K, 7) positions [m] and unit quaternions w, x, y, z.
            jobs: number of threads, by default one per core. It does not change the result.
            unwound: (K, m) unwound lengths [m]. With these and `gravity`, cables that sag are curves, and each distance
                has an error of at most 1e-6 m. Otherwise they are straight, like all others.

        Returns:
            Clearances (K,) [m], infinite if nothing can touch; and indices (K,) of the closest pairs for `name`.

        Raises:
            CdprError: if an argument has another shape, or if poses are not finite.

        Example:
            >>> import cdpr
            >>> robot = cdpr.load_robot("caroca")
            >>> gaps, which = clearance(robot, diameter=0.01).at(robot.home[None])
            >>> gaps.shape, which.shape
            ((1,), (1,))
        """
        given = np.ascontiguousarray(checked(poses, (None, 7), "poses", finite=True))
        least, which = np.empty(len(given)), np.empty(len(given), dtype=np.int64)
        bodies = self.bodies._asdict()
        lengths, kernel = None, "clearances"
        if unwound is not None and self.sagging:
            lengths = np.ascontiguousarray(checked(unwound, (len(given), self.robot.m), "unwound"))
            bodies, kernel = bodies | self.sagging, "sagging_clearances"

        def part(cut: slice) -> None:
            curved = {} if lengths is None else {"unwound": lengths[cut]}
            bind(kernel, **bodies, **curved, poses=given[cut], clearance=least[cut], which=which[cut]).unlocked()

        in_threads(len(given), part, jobs)
        return least, which

    def without(self, cables: Iterable[int]) -> Clearance:
        """Return the same clearances without the given cables, numbered from 0."""
        radius = self.bodies.radius.copy()
        radius[list(cables)] = GONE
        return replace(self, bodies=self.bodies._replace(radius=radius))

    def name(self, which: int) -> str:
        """Return the names of the closest pair."""
        m, names = self.robot.m, [cable.name for cable in self.robot.cables]
        if which < 0:
            return "nothing"
        if which < m * m:
            return f"{names[which // m]} and {names[which % m]}"
        k, i = divmod(which - m * m, m)
        return f"{names[i]} and {PLATFORM}" if k == 0 else f"{names[i]} and {self.obstacles[k - 1].name}"


def clearance(
    robot: Robot,
    obstacles: Sequence[Obstacle] = (),
    diameter: float | None = None,
    gravity: ArrayLike | None = None,
) -> Clearance:
    """Return the clearances of a robot.

    Args:
        robot: robot with the anchors, the exit points, the platform's shape and the diameters of the cables.
        obstacles: obstacles in the world.
        diameter: diameter of all cables [m], by default their own diameters.
        gravity: (3,) m/s^2, world axes, for the curves of cables that sag.

    Raises:
        CdprError: if a diameter is not known or is not a finite length of at least 0 m.
    """
    sizes = [cable.diameter if diameter is None else diameter for cable in robot.cables]
    for cable, size in zip(robot.cables, sizes, strict=True):
        if size is None:
            raise CdprError(
                f"cable '{cable.name}' has no diameter: give the robot cable.diameter, or a `diameter` of all cables, m"
            )
        if not 0.0 <= size < math.inf:
            raise CdprError(f"diameter: expected a length of at least 0 m, got {shown(size)}")
    radius, m = 0.5 * np.array(sizes, dtype=float), robot.m
    pairs = np.full((m, m), APART, dtype=np.int64)
    sharing = []
    for i in range(m):
        for j in range(i):
            thick = radius[i] + radius[j]
            ends = (robot.anchors[i] - robot.anchors[j]).reshape(2, 3)
            apart = np.linalg.norm(ends, axis=1)
            frame, platform = (apart <= thick).tolist()
            if frame != platform or (apart <= ON_SURFACE).all():
                pairs[i, j] = SAME if frame and platform else SHARED
                pairs[j, i] = SHARED if platform else APART
                sharing.append((robot.cables[j].name, robot.cables[i].name))
    shape = robot.platform.shape
    own = np.zeros((0, solids.WIDTH)) if shape is None else solids.row(shape)[None]
    places = [solids.row(each.shape, each.position, tuple(each.attitude.tolist())) for each in obstacles]
    others = solids.rows(places)
    platform = np.tile([cable.platform for cable in robot.cables], 2)
    deep = np.ones(m, dtype=bool) if shape is None else solid_distances(own[0], platform) < -ON_SURFACE
    inside = [cable.name for cable, within in zip(robot.cables, deep, strict=True) if within]
    bodies = Bodies(line_table(robot), radius, pairs, own, others)
    down = None if gravity is None else checked(gravity, (3,), "gravity", finite=True)
    return Clearance(robot, tuple(obstacles), bodies, tuple(sharing), tuple(inside), down)
