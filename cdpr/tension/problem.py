"""One wrench at one pose: what its distributions are, before any solver is asked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cdpr.model.kinematics import make_state, wrench_matrix
from cdpr.model.properties import conditioning, free_wrench_matrix
from cdpr.model.robot import Array, Robot
from cdpr.tension import active_set, null_space, polygon
from cdpr.tension.active_set import nearest

# The largest possible margin is found by halving an interval so often: to a billionth of its first guess and better.
HALVINGS = 50
WIDEST = 1e12  # N: limits that have to be widened by more than this are of no interest


@dataclass(frozen=True, eq=False)
class Problem:
    """W t = wrench, t_min <= t <= t_max: a robot with m cables and n degrees of freedom at a pose."""

    robot: Robot
    pose: Array  # (7,): position, m, and quaternion
    wrench: Array  # (6,): what the cables must exert at the platform's origin, world axes, N and N m

    @cached_property
    def W(self) -> Array:  # noqa: N802 - the field's name
        """Rows of the wrench matrix that belong to the degrees of freedom, (n, m)."""
        return np.ascontiguousarray(wrench_matrix(self.robot, make_state(self.pose[:3], self.pose[3:]))[self._rows])

    @cached_property
    def wanted(self) -> Array:
        """The same rows of the wrench, (n,)."""
        return np.ascontiguousarray(self.wrench[self._rows])

    @cached_property
    def weights(self) -> Array:
        """What makes a residual newtons, (n,): 1 for forces, 1 / characteristic length for moments."""
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
        """Particular solution t_0 (m,) of least norm and orthonormal null space N (m, r) of W; all t are t_0 + N x.

        None where W cannot produce the wrench at all.
        """
        n, m = self.W.shape
        particular, basis = np.zeros(m), np.zeros((m, m))
        rank = null_space.split(self.W, self.wanted, particular, basis, np.zeros(null_space.work_size(n, m)))
        return None if rank < 0 else (particular, np.ascontiguousarray(basis[:, : m - rank]))

    @cached_property
    def corners(self) -> Array | None:
        """Corners of the admissible x, (k, r): ends of an interval, polygon anticlockwise; None unless r is 1 or 2."""
        if self.general is None or self.general[1].shape[1] not in (1, 2):
            return None
        particular, N = self.general
        low, high = self.limits
        if N.shape[1] == 1:
            ends = np.zeros(2)
            return ends[: polygon.interval(N, particular, low, high, ends), None]
        vertices, work = np.zeros((polygon.most_vertices(len(N)), 2)), np.zeros(polygon.work_size(len(N)))
        return vertices[: polygon.polygon(N, particular, low, high, vertices, work)]

    @cached_property
    def margin(self) -> float | None:
        """The largest possible smallest distance of a tension from its limits, N; None where W cannot.

        Negative where no tensions are admissible: by so much the limits would have to be widened.
        """
        if self.general is None:
            return None
        most = float(np.min(self.limits[1] - self.limits[0])) / 2.0
        if self._within(most) is not None:
            return most
        low, step = min(0.0, most), 1.0
        while self._within(low) is None:
            low -= step
            step *= 2.0
            if step > WIDEST:
                return None
        high = most
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self._within(middle) is None else (middle, high)
        return low

    @property
    def feasible(self) -> bool:
        """Whether some tensions within the limits balance the wrench."""
        return self._within(0.0) is not None

    @property
    def centre(self) -> Array | None:
        """An x (r,) of the largest possible margin, N; None where there is none."""
        return None if self.margin is None else self._within(self.margin)

    def x(self, tension: Array) -> Array:
        """Null-space coordinates (r,), N, of tensions (m,): of the nearest balanced ones, where they are not."""
        assert self.general is not None
        particular, N = self.general
        return np.asarray(N.T @ (tension - particular))

    def _within(self, margin: float) -> Array | None:
        """An x (r,) whose tensions stay so far within the limits, if there is one."""
        if self.general is None:
            return None
        particular, N = self.general
        m, r = N.shape
        x, point, active, work = np.zeros(r), np.zeros(m), np.zeros(m), np.zeros(active_set.work_size(m, r))
        low, high = self.limits[0] + margin, self.limits[1] - margin
        found = bool((low <= high).all()) and nearest(N, r, particular, low, high, x, point, active, work) >= 0
        return x if found else None

    @property
    def _rows(self) -> list[int]:
        return self.robot.rows
