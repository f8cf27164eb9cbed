"""Set of all tensions that balance a wrench at a pose, from which every solver chooses."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.analysis.distribution.distributions import check_unit
from cdpr.analysis.distribution.source import robot_and_gravity
from cdpr.base.errors import CdprError
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.mechanics.properties import check_lengths
from cdpr.model.arrays import checked
from cdpr.model.frozen import Frozen
from cdpr.model.rank import RANK_TOLERANCE
from cdpr.model.robot import Array, frozen_array
from cdpr.scenario.loader import AnyRobot
from cdpr.tension.checks import LIMIT_TOLERANCE, newton
from cdpr.tension.problem import Problem

# Relative determinant of three normals below which their limits meet in an edge, not in a corner.
FLAT = 1e-9

# Share of the largest limit within which corners satisfy the other limits and two corners are equal: round-off of a
# nearly singular 3 x 3 system.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Admissible(Frozen):
    """Tensions { t = particular + basis x : t_min <= t <= t_max } of m cables that balance a wrench.

    The robot has n degrees of freedom. The null space has dimension r: m - n, more if W is singular, less if cables are
    locked. If no tensions at all produce the wrench (`reachable` is False), all arrays are empty or NaN.
    """

    reachable: bool  # True if some tensions of any size and sign balance the wrench
    feasible: bool  # True if some within the limits do, to 1e-6 N, or 1e-6 of the largest limit if smaller
    W: Array  # (n, m), rows of the wrench matrix for the degrees of freedom
    wrench: Array  # (n,), N and N m, the same rows of the wrench
    particular: Array  # (m,), N, balanced tensions of least 2-norm; locked cables keep theirs
    basis: Array  # (m, r), orthonormal basis of the null space: changes of the tensions without a wrench
    vertices: Array | None  # (k, m), N, corners of the set, ordered around it for r = 2; None if r > 3
    range: Array  # (m, 2), N, smallest and largest admissible tension of each cable; NaN if the set is empty
    margin: float  # N, largest distance of all tensions from their limits; negative if infeasible
    safest: Array  # (m,), N, tensions with this distance
    active: NDArray[np.int64]  # (m,): -1, 1 if `safest` is as close as `margin` to the lower, upper limit, else 0
    sensitivity: Array  # (m, n), dt/dw = W^+ of the unlocked cables: change of `particular` with the wrench

    def __repr__(self) -> str:
        m, r = self.basis.shape
        found = "feasible" if self.feasible else "infeasible" if self.reachable else "out of reach"
        return f"<Admissible tensions of {m} cables: {found}, margin {self.margin:.4g} N, {r} to choose>"

    @property
    def redundancy(self) -> int:
        """Dimension r of the null space."""
        return int(self.basis.shape[1])


def admissible(
    robot: AnyRobot,
    pose: ArrayLike,
    wrench: ArrayLike | None = None,
    *,
    gravity: ArrayLike | None = None,
) -> Admissible:
    """Return all tensions that balance one wrench at one pose.

    Smallest and largest tensions are optima of linear programs, exact up to round-off (Mangasarian and Meyer, SIAM J.
    Control Optim. 17, 1979). The corners are those of an interval, a polygon (Gouttefarde, Lamaury, Reichert and
    Bruckmann, IEEE Trans. Robotics 31, 2015) or, for r = 3, intersections of three limits that satisfy all others.

    Args:
        robot: geometry, limits and degrees of freedom: a Robot, a file, the name of an example, a dict or a Scenario,
            whose controlled directions and gravity apply.
        pose: (7,), position (m) and quaternion w, x, y, z of the platform.
        wrench: (6,), wrench of the cables on the platform at its origin (N, N m, world axes); by default the one that
            balances `gravity` at rest.
        gravity: (3,), m/s^2, world; by default the scenario's, or the earth's.

    Returns:
        The set of tensions with its corners, ranges, margin and sensitivity; see `Admissible`.

    Raises:
        CdprError: if an argument has the wrong type or shape or is not finite, the quaternion does not have length 1,
            or a cable has zero length at this pose.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> found = cdpr.admissible(robot, robot.home)
        >>> found.feasible, found.redundancy, found.range.shape
        (True, 2, (8, 2))
    """
    robot, gravity = robot_and_gravity(robot, gravity)
    at = checked(pose, (7,), "pose", finite=True).copy()
    check_unit(at[None], "pose")
    at[3:] /= np.linalg.norm(at[3:])
    down = checked(gravity, (3,), "gravity", finite=True)
    load = required_wrench(robot, make_state(at[:3], at[3:]), down) if wrench is None else wrench
    problem = Problem(robot, at, checked(load, (6,), "wrench", finite=True))
    return admissible_of(problem)


def admissible_of(problem: Problem) -> Admissible:
    """Return the admissible tensions of a problem; errors as in `admissible`."""
    check_lengths(problem.robot, problem.pose)
    m, n = problem.robot.m, problem.robot.n
    W, wanted = frozen_array(problem.W), frozen_array(problem.wanted)
    low, high = problem.limits
    if not np.isfinite(problem.limits).all():
        raise CdprError("limits: expected finite limits, because infinite limits may leave the tensions unbounded")
    free = low < high
    sensitivity = np.zeros((m, n))
    sensitivity[free] = np.linalg.pinv(problem.W[:, free], rcond=RANK_TOLERANCE)
    nothing = frozen_array(np.full(m, np.nan))
    if problem.general is None:
        basis, span = frozen_array(np.empty((m, 0))), frozen_array(np.full((m, 2), np.nan))
        idle = _frozen(np.zeros(m, dtype=np.int64))
        return Admissible(
            reachable=False,
            feasible=False,
            W=W,
            wrench=wanted,
            particular=nothing,
            basis=basis,
            vertices=None,
            range=span,
            margin=-np.inf,
            safest=nothing,
            active=idle,
            sensitivity=frozen_array(sensitivity),
        )
    c, N = problem.general
    margin, safest = (np.nan, nothing) if problem.safest is None else (problem.safest[0], c + N @ problem.safest[1])
    near = margin + LIMIT_TOLERANCE * newton(problem.limits)
    active = np.where(free & (safest - low <= near), -1, np.where(free & (high - safest <= near), 1, 0))
    corners = _corners(problem, c, N)
    return Admissible(
        reachable=True,
        feasible=problem.feasible,
        W=W,
        wrench=wanted,
        particular=frozen_array(c),
        basis=frozen_array(N),
        vertices=corners,
        range=frozen_array(problem.ranges),
        margin=margin,
        safest=frozen_array(safest),
        active=_frozen(active),
        sensitivity=frozen_array(sensitivity),
    )


def _frozen(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    numbers.flags.writeable = False
    return numbers


def _corners(problem: Problem, c: Array, N: Array) -> Array | None:
    """Return the corners of the admissible set, (k, m), N; None if it has more than three dimensions."""
    (low, high), r = problem.limits, N.shape[1]
    if r > 3:
        return None
    if r == 0:
        return frozen_array(np.clip(c[None], low, high) if problem.feasible else np.empty((0, len(c))))
    x = problem.corners if r < 3 else _corners_in_space(c, N, low, high)
    assert x is not None
    return frozen_array(np.clip(c + x @ N.T, low, high))


def _corners_in_space(c: Array, N: Array, low: Array, high: Array) -> Array:
    """Return the corners (k, 3) of { x : low <= c + N x <= high }, where three limits meet and all others hold."""
    normals, offsets = np.concatenate([N, N]), np.concatenate([low - c, high - c])
    size = np.linalg.norm(normals, axis=1)
    rows = np.flatnonzero(size > 0.0)  # `reduce` leaves no rows of round-off
    triples = rows[np.array(list(combinations(range(len(rows)), 3)), dtype=np.int64).reshape(-1, 3)]
    A, b = normals[triples], offsets[triples]
    spanning = np.abs(np.linalg.det(A)) > FLAT * size[triples].prod(axis=1)
    x = np.linalg.solve(A[spanning], b[spanning][:, :, None])[:, :, 0]
    near = SAME * max(1.0, float(np.abs([low, high]).max()))
    t = c + x @ N.T
    x = x[((t >= low - near) & (t <= high + near)).all(axis=1)]
    kept: list[Array] = []
    for corner in x:
        if all(np.abs(corner - other).max() > near for other in kept):
            kept.append(corner)
    return np.array(kept).reshape(-1, 3)
