"""Tension distribution problem of one wrench at one pose, and its properties independent of solvers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.mechanics.properties import conditioning, free_wrench_matrix
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, Robot
from cdpr.tension.active_set import extreme_tensions
from cdpr.tension.admissible import admissible_corners, farthest_from_limits, general_solution
from cdpr.tension.checks import LIMIT_TOLERANCE, newton


@dataclass(frozen=True, eq=False)
class Problem:
    """Problem W t = wrench, t_min <= t <= t_max of a robot with m cables and n degrees of freedom at a pose."""

    robot: Robot
    pose: Array  # (7,): position, m, and quaternion
    wrench: Array  # (6,), required wrench at the platform's origin, world axes, N and N m

    def __post_init__(self) -> None:
        """Raise CdprError if pose or wrench are no real numbers of these shapes."""
        object.__setattr__(self, "pose", checked(self.pose, (7,), "pose"))
        object.__setattr__(self, "wrench", checked(self.wrench, (6,), "wrench"))

    @cached_property
    def W(self) -> Array:  # noqa: N802 - the field's name
        """Rows of the wrench matrix for the degrees of freedom, (n, m)."""
        return np.ascontiguousarray(wrench_matrix(self.robot, make_state(self.pose[:3], self.pose[3:]))[self._rows])

    @cached_property
    def wanted(self) -> Array:
        """Same rows of the wrench, (n,)."""
        return np.ascontiguousarray(self.wrench[self._rows])

    @cached_property
    def weights(self) -> Array:
        """Weights that convert a residual to newtons, (n,): 1 for forces, 1 / characteristic length for moments."""
        return np.repeat([1.0, 1.0 / self.robot.characteristic_length], 3)[self._rows]

    @cached_property
    def limits(self) -> Array:
        """Lowest and highest tensions, (2, m), N."""
        return np.array([self.robot.tension_min, self.robot.tension_max])

    @cached_property
    def conditioning(self) -> tuple[int, float]:
        """Rank and condition number of W, moments divided by the characteristic length."""
        state = make_state(self.pose[:3], self.pose[3:])
        return conditioning(free_wrench_matrix(self.robot, state))

    @cached_property
    def general(self) -> tuple[Array, Array] | None:
        """Particular solution c (m,) and orthonormal null space N (m, r): all t with W t = wrench are c + N x.

        c is the solution of least norm; cables with equal limits are locked, and x does not change them. None if W
        cannot produce the wrench at all.
        """
        return general_solution(self.W, self.wanted, *self.limits)

    @cached_property
    def corners(self) -> Array | None:
        """Corners of the admissible x, (k, r): ends of an interval, polygon anticlockwise; None unless r is 1 or 2."""
        if self.general is None or self.general[1].shape[1] not in (1, 2):
            return None
        c, N = self.general
        low, high = self.limits
        return admissible_corners(N, c, low, high)

    @cached_property
    def safest(self) -> tuple[float, Array] | None:
        """Largest margin of all tensions from their limits, N, and an x (r,) that has it.

        Negative if no tensions are admissible: the limits would have to be wider by that amount. Locked cables are
        ignored; inf if all are locked. None if W cannot produce the wrench at all.
        """
        if self.general is None:
            return None
        c, N = self.general
        margin, x = farthest_from_limits(N, c, *self.limits)
        return None if math.isnan(margin) else (margin, x)

    @cached_property
    def ranges(self) -> Array:
        """Smallest and largest tension of each cable within the admissible set, (m, 2), N; NaN if it is empty.

        They are optima of linear programs; limits must be finite.
        """
        low, high = self.limits
        if self.general is None or not self.feasible:
            return np.full((len(low), 2), np.nan)
        c, N = self.general
        return extreme_tensions(N, c, low, high)

    @property
    def feasible(self) -> bool:
        """True if some tensions within the limits balance the wrench."""
        return self.safest is not None and bool(self.safest[0] >= -LIMIT_TOLERANCE * newton(self.limits))

    def x(self, tension: Array) -> Array:
        """Return null-space coordinates (r,), N, of tensions (m,), or of the nearest balanced tensions."""
        assert self.general is not None
        c, N = self.general
        return np.asarray(N.T @ (tension - c))

    @property
    def _rows(self) -> list[int]:
        return self.robot.rows
