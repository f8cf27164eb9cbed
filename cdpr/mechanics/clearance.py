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
from importlib import import_module
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.cables.lines import ANCHORS, lines
from cdpr.errors import CdprError
from cdpr.mechanics import geometry, solids
from cdpr.mechanics.contacts import PLATFORM
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.jit import DISABLED, kernel, threaded_kernel
from cdpr.model.kernels import Quaternion, Vector, conjugate, quaternion, rotate, vector
from cdpr.model.kinds import INDICES, NOTHING, ROW, TABLE, WHOLE, Block, Group
from cdpr.model.lanes import choose, of_lanes
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.model.threads import in_threads

# An anchor so near to the surface of its platform, m, is on it: less than cables are thick, more than files are round.
ON_SURFACE = 1e-5

# What is asked of a pair of cables.
APART, SHARED, SAME = range(3)

MANY = 64  # poses: from here on eight at a time, which take a kernel more to load

# Half the diameter of a cable that is broken: whatever it is near to is infinitely far from it.
GONE = -math.inf

INT_TABLE = Block(WHOLE, 2)


class Bodies(NamedTuple):
    """What may touch."""

    lines: Array  # (m, 6 or more), as `cdpr.cables.lines` says
    radius: Array  # (m,), m; GONE of a cable that is no more
    pairs: NDArray[np.int64]  # (m, m), what is asked
    platform: Array  # (0 or 1, 11), as `cdpr.mechanics.solids` has it, platform axes
    obstacles: Array  # (k, 11 or more), world


class Nearest(NamedTuple):
    """Of K poses."""

    poses: Array  # (K, 7), given
    clearance: Array  # (K,), m
    which: NDArray[np.int64]  # (K,), i m + j of two cables; from m^2 on its platform; from m^2 + m on obstacles


BODIES, NEAREST = Group((TABLE, ROW, INT_TABLE, TABLE, TABLE), Bodies), Group((TABLE, ROW, INDICES), Nearest)


def _exit(ends: Array, lines: Array, i: int, P: Vector) -> Vector:
    """Return where cable i leaves the frame on its way to P."""
    return geometry.exit_point(lines, i, P)


@of_lanes(_exit)
def _point(ends: Array, lines: Array, i: int, P: Vector) -> Vector:
    """Return where cable i leaves the frame: from a point, the same for all of eight."""
    return (lines[i, 0], lines[i, 1], lines[i, 2])


@kernel
def among_cables(bodies: Bodies, p: Vector, q: Quaternion, ends: Array) -> tuple[float, float]:
    """Write where cables begin and end, (m, 6), m; return their least clearance and whose it is; of lanes, too.

    With lanes all cables leave from points.
    """
    lines, radius, m = bodies.lines, bodies.radius, bodies.lines.shape[0]
    for i in range(m):
        _, P = geometry.tip(lines, i, p, q)
        E = _exit(ends, lines, i, P)
        for j in range(3):
            ends[i, j], ends[i, 3 + j] = E[j], P[j]
    least, which = math.inf, -1.0
    for i in range(m):
        E, P = vector(ends[i], 0), vector(ends[i], 3)
        for j in range(i):
            asked = bodies.pairs[i, j]
            if asked == SAME:
                continue
            F, Q = vector(ends[j], 0), vector(ends[j], 3)
            if asked == APART:
                value = solids.between(E, P, F, Q)
            elif bodies.pairs[j, i] == SHARED:  # on the platform
                value = min(solids.from_point(E, F, Q), solids.from_point(F, E, P))
            else:
                value = min(solids.from_point(P, F, Q), solids.from_point(Q, E, P))
            value -= radius[i] + radius[j]
            nearer = value < least
            least, which = choose(nearer, value, least), choose(nearer, 1.0 * (j * m + i), which)
    return least, which


@kernel
def nearest(bodies: Bodies, pose: Array, ends: Array) -> tuple[float, int]:
    """Return the least clearance at a pose (7,), m, and of what, -1 of nothing; `ends` (m, 6) is work space."""
    least, which = among_cables(bodies, vector(pose, 0), quaternion(pose, 3), ends)
    return among_solids(bodies, pose, ends, least, int(which))


@kernel
def among_solids(bodies: Bodies, pose: Array, ends: Array, least: float, which: int) -> tuple[float, int]:
    """Return what is less than this clearance: of cables, whose ends are known, from their platform and obstacles."""
    lines, radius, m = bodies.lines, bodies.radius, bodies.lines.shape[0]
    p, q = vector(pose, 0), quaternion(pose, 3)
    for k in range(bodies.platform.shape[0]):
        solid = bodies.platform[k]
        for i in range(m):
            if radius[i] == GONE:
                continue
            anchor = solids.into(solid, vector(lines[i], 3))
            value, _ = solids.signed_distance(solid, anchor)
            if value < -ON_SURFACE:
                continue
            c = rotate(conjugate(q), (ends[i, 0] - p[0], ends[i, 1] - p[1], ends[i, 2] - p[2]))
            if value <= ON_SURFACE:
                value = solids.above(solid, anchor, solids.into(solid, c), ON_SURFACE)
            else:
                value = solids.from_solid(solid, vector(lines[i], 3), c) - radius[i]
            if value < least:
                least, which = value, m * m + i
    for k in range(bodies.obstacles.shape[0]):
        for i in range(m):
            E, P = vector(ends[i], 0), vector(ends[i], 3)
            if solids.beyond(bodies.obstacles[k], E, P) - radius[i] >= least:
                continue
            value = solids.from_solid(bodies.obstacles[k], E, P) - radius[i]
            if value < least:
                least, which = value, m * m + m + k * m + i
    return least, which


@kernel
def look(bodies: Bodies, found: Nearest, ends: Array) -> None:
    """Write what is found of all poses; `ends` (m, 6) is work space."""
    for k in range(found.poses.shape[0]):
        found.clearance[k], found.which[k] = nearest(bodies, found.poses[k], ends)


@threaded_kernel(NOTHING(BODIES, NEAREST))
def look_beside(bodies: Bodies, found: Nearest) -> None:
    """Do so, and let other threads run meanwhile."""
    look(bodies, found, np.empty((bodies.lines.shape[0], 6)))


class Watch(NamedTuple):
    """When cables are too near."""

    radius: Array  # (m,), m, of all cables
    gone: Array  # (m,), s, when they break; infinite of those that do not
    level: Array  # (2,): at this clearance, m, or below, and from this time on, s
    ends: Array  # (m, 6), work space


@kernel
def too_near(bodies: Bodies, watch: Watch, pose: Array, time: float) -> bool:
    """Whether cables are too near at a pose (7,); `bodies` belong to who asks: here cables break in them."""
    if time < watch.level[1]:
        return False
    for i in range(watch.radius.shape[0]):
        bodies.radius[i] = watch.radius[i] if time < watch.gone[i] else GONE
    least, _ = nearest(bodies, pose, watch.ends)
    near: bool = least <= watch.level[0]
    return near


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

    def at(self, poses: ArrayLike, jobs: int | None = None, *, plain: bool = False) -> tuple[Array, NDArray[np.int64]]:
        """Return the least clearance at poses (K, 7), (K,), m, and of what, (K,), for `name`.

        The same, and slower, if `plain`: one after the other, without what many at a time take to load.
        """
        given = np.ascontiguousarray(checked(poses, (None, 7), "poses", finite=True))
        found = Nearest(given, np.empty(len(given)), np.empty(len(given), dtype=np.int64))
        if plain:
            look(self.bodies, found, np.empty((self.robot.m, 6)))
            return found.clearance, found.which
        eights = None
        if len(given) >= MANY and self.bodies.lines.shape[1] == ANCHORS and not DISABLED:
            eights = import_module("cdpr.mechanics.clearance_eights")

        def part(cut: slice) -> None:
            these = Nearest(found.poses[cut], found.clearance[cut], found.which[cut])
            if eights is None:
                look_beside(self.bodies, these)
            else:
                eights.look_eights(self.bodies, these, *eights.memory(self.robot.m))

        in_threads(len(given), part, jobs)
        return found.clearance, found.which

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
    inside = [cable.name for cable in robot.cables if shape is None or _depth(own[0], cable.platform) > ON_SURFACE]
    return Clearance(
        robot, tuple(obstacles), Bodies(lines(robot).copy(), radius, pairs, own, others), tuple(sharing), tuple(inside)
    )


def _depth(solid: Array, point: Array) -> float:
    """How far a point (3,) is inside of a solid, m."""
    x, y, z = point.tolist()
    return -solids.signed_distance(solid, solids.into(solid, (x, y, z)))[0]
