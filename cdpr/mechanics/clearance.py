"""How far cables are from each other, from their own platform and from obstacles.

The axis of a cable is the segment from where it leaves the frame to its anchor on the platform; a clearance is the
distance of axes less both radii, or of an axis from a solid less its radius: negative where they touch.

- Cables whose anchors on one side are nearer than they are thick share that anchor: they touch there always, and
  elsewhere only where they lie along each other. Of these the distance of each one's other end from the other counts.
  Those that are so near on both sides, but not in the same points, touch all along.
- A cable from the surface of its own platform, a convex solid, passes through it where its other end is below all faces
  that its anchor is on (the tangent cone); how far it is above the highest of them counts. Of an anchor outside it is
  the cable's distance from the solid; one inside tells nothing, for the solid is then no picture of the platform.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.cables.tables import line_table
from cdpr.errors import CdprError
from cdpr.mechanics import solids
from cdpr.mechanics.contacts import PLATFORM
from cdpr.mechanics.distances import solid_distances
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.model.threads import in_threads
from cdpr.native.bind import bind

# An anchor so near to the surface of its platform, m, is on it: less than cables are thick, more than files are round.
ON_SURFACE = 1e-5

# Distances that count for a pair of cables, as in clearance.hpp.
APART, SHARED, SAME = range(3)

# Radius of a cable that is broken: whatever it is near to is infinitely far from it.
GONE = -math.inf


class Bodies(NamedTuple):
    """Bodies and pairs that may touch, as operations of the kernel library take them (clearance.hpp)."""

    lines: Array  # (m, w), as of `cdpr.cables.tables.line_table`
    radius: Array  # (m,), m; GONE of a cable that is broken
    pairs: NDArray[np.int64]  # (m, m), APART, SHARED or SAME
    platform: Array  # (0 or 1, 11), as `cdpr.mechanics.solids` has it, platform axes
    obstacles: Array  # (k, 11 or more), world


@dataclass(frozen=True, eq=False)
class Clearance:
    """Who may touch whom.

    Attributes:
        robot: whose cables these are.
        obstacles: what else is there.
        bodies: the same for kernels.
        sharing: names of pairs of cables that share an anchor.
        unjudged: names of cables whose anchor is inside the platform's shape, or all where it has none.
    """

    robot: Robot
    obstacles: tuple[Obstacle, ...]
    bodies: Bodies
    sharing: tuple[tuple[str, str], ...]
    unjudged: tuple[str, ...]

    def at(self, poses: ArrayLike, jobs: int | None = None) -> tuple[Array, NDArray[np.int64]]:
        """Compute the least clearance at each of many poses.

        Args:
            poses: (K, 7): position m and unit quaternion w x y z.
            jobs: threads; one for each core unless given. The result is the same.

        Returns:
            Clearances (K,) m, inf where nothing can touch; and of what, (K,), for `name`.

        Raises:
            CdprError: The poses have another shape or are not finite.

        Example:
            >>> gaps, which = clearance(robot).at(robot.home[None])
        """
        given = np.ascontiguousarray(checked(poses, (None, 7), "poses", finite=True))
        least, which = np.empty(len(given)), np.empty(len(given), dtype=np.int64)
        bodies = self.bodies._asdict()

        def part(cut: slice) -> None:
            bind("clearances", **bodies, poses=given[cut], clearance=least[cut], which=which[cut]).unlocked()

        in_threads(len(given), part, jobs)
        return least, which

    def without(self, cables: Iterable[int]) -> Clearance:
        """Return the same where these cables, counted from 0, are no more."""
        radius = self.bodies.radius.copy()
        radius[list(cables)] = GONE
        return replace(self, bodies=self.bodies._replace(radius=radius))

    def name(self, which: int) -> str:
        """Return what is nearest to what."""
        m, names = self.robot.m, [cable.name for cable in self.robot.cables]
        if which < 0:
            return "nothing"
        if which < m * m:
            return f"{names[which // m]} and {names[which % m]}"
        k, i = divmod(which - m * m, m)
        return f"{names[i]} and {PLATFORM}" if k == 0 else f"{names[i]} and {self.obstacles[k - 1].name}"


def clearance(robot: Robot, obstacles: Sequence[Obstacle] = (), diameter: float | None = None) -> Clearance:
    """Return who may touch whom.

    Args:
        robot: gives anchors, exits, the platform's shape, and the cables' diameters.
        obstacles: what else is there.
        diameter: of all cables, m; their own unless given.

    Raises CdprError where a diameter is not known.
    """
    sizes = [cable.diameter if diameter is None else diameter for cable in robot.cables]
    for cable, size in zip(robot.cables, sizes, strict=True):
        if size is None:
            raise CdprError(
                f"cable '{cable.name}' has no diameter: give the robot cable.diameter, or say --cable-diameter (m)"
            )
        if not 0.0 <= size < math.inf:
            raise CdprError(f"diameter: a length of at least 0 m is expected, got {size!r}")
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
    return Clearance(
        robot, tuple(obstacles), Bodies(line_table(robot), radius, pairs, own, others), tuple(sharing), tuple(inside)
    )
