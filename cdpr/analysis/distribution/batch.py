"""Distribution of many rows by one compiled operation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cdpr.cables.tables import line_table
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import LANES, Compiled, bind
from cdpr.plugins import CompiledSolver
from cdpr.tension.policy import action

if TYPE_CHECKING:
    from cdpr.native.library import Bound


@dataclass(frozen=True, eq=False)
class Rows:
    """K problems of a robot with m cables, and the arrays of their results."""

    limits: Array  # (K, 2, m), N, or (1, 2, m) for all
    poses: Array  # (K, 7), quaternions of any length
    wrenches: Array  # (K, 6), N and N m; or (0, 6): static wrench against gravity
    tension: Array  # (K, m), N, written
    report: Array  # (K, 4), written: status, residual, N, margin, N, and number of cables at a limit
    done: NDArray[np.int64]  # (K,), written: nonzero for completed rows, which are skipped

    @classmethod
    def of(cls, limits: Array, poses: Array, wrenches: Array, tension: Array, report: Array) -> Self:
        """Return rows of which none is completed."""
        return cls(limits, poses, wrenches, tension, report, np.zeros(len(poses), dtype=np.int64))


class BoundRows(NamedTuple):
    """Bound operation that distributes rows, and the solver's operation, which it calls by its address."""

    call: Bound
    solver: Compiled

    def distribute(self) -> None:
        """Write the results; the GIL is released."""
        self.call.unlocked()


class Batch:
    """Distribution of rows as in the tension stage, each as a first step.

    Rows with non-finite entries or contradictory limits get BAD_INPUT and NaN tensions.

    Args:
        robot: geometry and degrees of freedom.
        gravity: (3,), m/s^2, world; read when rows are distributed.
        solver: solver for this robot.
        respects_bounds: True if it declares that it respects the limits.
    """

    def __init__(self, robot: Robot, gravity: Array, solver: CompiledSolver, respects_bounds: bool) -> None:
        self._solver = solver
        self._size = robot.n, robot.m
        self._action = action("best_effort", respects_bounds)
        self._robot = {
            "lines": np.array(line_table(robot)),
            "inertial": robot.inertial,
            "gravity": gravity,
            "weights": np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows],
        }
        self._freedom = np.array(robot.rows)

    def bind(self, rows: Rows) -> BoundRows:
        """Bind the rows for sequential processing with their own work space."""
        arrays = self._problem()
        matrix, wrench, bounds, answer = arrays.values()
        solve = self._solver.compiled(matrix, wrench, bounds[0], bounds[1], answer)
        where = {"solver": solve.operation, "solver_place": solve.place}
        call = bind("distribute_rows", **self._robot, **self._given(rows), **arrays, **where, action=self._action)
        return BoundRows(call, solve)

    def bind_side_by_side(self, rows: Rows) -> BoundRows | None:
        """Bind rows that the solver processes eight at a time, with the same bits; None if it cannot."""
        arrays = self._problem(LANES)
        matrix, wrench, bounds, answer = arrays.values()
        solve = self._solver.side_by_side(matrix, wrench, bounds[0], bounds[1], answer)
        if solve is None:
            return None
        robot = {name: np.repeat(array[..., None], LANES, axis=-1) for name, array in self._robot.items()}
        where = {"solver": solve.operation, "solver_place": solve.place}
        return BoundRows(bind("distribute_rows_lanes", **robot, **self._given(rows), **arrays, **where), solve)

    def _problem(self, *lanes: int) -> dict[str, Array]:
        n, m = self._size
        shapes = {"matrix": (n, m), "wrench": (n,), "bounds": (2, m), "answer": (m,)}
        return {name: np.empty((*shape, *lanes)) for name, shape in shapes.items()}

    def _given(self, rows: Rows) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
        return {
            "freedom": self._freedom,
            "limits": rows.limits,
            "poses": rows.poses,
            "wrenches": rows.wrenches,
            "tensions": rows.tension,
            "reports": rows.report,
            "done": rows.done,
        }
