"""Distribution of single rows by operations that stay bound between calls, for controllers with thousands of calls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.analysis.distribution.batch import Batch, BoundRows, Rows
from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.arrays import masked
from cdpr.plugins import CompiledSolver
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.registry import Registered, registry

KEPT = 16  # maximum number of bound operations
SIMPLE = str, int, float, bool  # option types with unique text

_idle: dict[tuple[int, str, str], Single] = {}  # operations not in use; a thread removes one while it uses it
_lock = Lock()


class Single:
    """Distribution of single rows by one solver.

    Args:
        robot: The robot.
        entry: The solver's, which it was made by.
        solver: Made for this robot.
        respects_bounds: Whether it declares that it respects the limits.
    """

    def __init__(self, robot: Robot, entry: Registered, solver: CompiledSolver, respects_bounds: bool) -> None:
        self.robot = robot  # keeps the robot alive, so that its id stays unique
        self.entry = entry
        self.low, self.high = robot.tension_min, robot.tension_max
        self.gravity = np.zeros(3)
        self.rows = Rows.of(
            np.empty((1, 2, robot.m)), np.empty((1, 7)), np.empty((1, 6)), np.empty((1, robot.m)), np.empty((1, 4))
        )
        self._batch = Batch(robot, self.gravity, solver, respects_bounds)

    def distribute(
        self, pose: Array, wrench: Array | None, low: Array | None, high: Array | None, gravity: ArrayLike
    ) -> tuple[Array, list[float]]:
        """Return tensions (m,), N, and their report: status, residual, N, margin, N, number of cables at a limit.

        Args:
            pose: (7,), position (m) and quaternion.
            wrench: (6,), N and N m; by default the static one against `gravity`.
            low: (m,), N, lowest tensions; by default the robot's.
            high: (m,), N, highest tensions; by default the robot's.
            gravity: (3,), m/s^2, world.
        """
        rows = self.rows
        rows.poses[0] = pose
        limits = rows.limits[0]
        limits[0] = self.low if low is None else low
        limits[1] = self.high if high is None else high
        rows.done[0] = 0
        if wrench is None:
            self.gravity[:] = gravity
            self._still.call()
        else:
            rows.wrenches[0] = wrench
            self._given.call()
        return rows.tension[0].copy(), rows.report[0].tolist()

    @cached_property
    def _given(self) -> BoundRows:
        return self._batch.bind(self.rows)

    @cached_property
    def _still(self) -> BoundRows:
        rows = self.rows
        return self._batch.bind(Rows(rows.limits, rows.poses, np.empty((0, 6)), rows.tension, rows.report, rows.done))


def distribute_single(
    robot: Robot,
    solver: str,
    options: Mapping[str, Any] | None,
    given: tuple[ArrayLike, ArrayLike | None, ArrayLike | None, ArrayLike | None],
    gravity: ArrayLike,
) -> tuple[Array, list[float]] | None:
    """Distribute one row with a solver by its name; return None if the arguments need further checks.

    Args:
        robot: The robot.
        solver: Name.
        options: Of the solver.
        given: Pose (7,), wrench (6,) or None, lowest and highest tensions (m,) or None.
        gravity: (3,) m/s^2, world; already checked.

    Returns:
        As `Single.distribute`.
    """
    m = robot.m
    pose, wrench, low, high = (
        None if each is None else _as_array(each, size) for each, size in zip(given, (7, 6, m, m), strict=True)
    )
    if pose is None or any((a is None) != (b is None) for a, b in zip(given, (pose, wrench, low, high), strict=True)):
        return None
    _, _, _, w, x, y, z = pose.tolist()
    if abs(math.sqrt(w * w + x * x + y * y + z * z) - 1.0) > tolerances.UNIT:
        return None
    if low is not None and robot.unilateral and (low < 0.0).any():
        return None
    text = _text(options)
    if text is None:
        return None
    key = id(robot), solver, text
    with _lock:
        single = _idle.pop(key, None)
    if single is None or single.entry is not registry().plugins["solver"].get(solver):
        single = _bound_solver(robot, solver, options)
    if single is None:
        return None
    found = single.distribute(pose, wrench, low, high, gravity)
    with _lock:
        _idle[key] = single
        if len(_idle) > KEPT:
            del _idle[next(iter(_idle))]
    return found


def _as_array(values: ArrayLike, size: int) -> Array | None:
    """Return numbers as an array (size,); None if they are anything else."""
    array: Any = values
    if type(array) in (list, tuple) and not masked(array):
        try:
            array = np.array(array)
        except (TypeError, ValueError):
            return None
    if type(array) is np.ndarray and array.dtype == np.float64 and array.shape == (size,):
        return array
    return None


def _text(options: Mapping[str, Any] | None) -> str | None:
    """Return a unique text of the options; None if they are not simple."""
    if options is None:
        return ""
    if not isinstance(options, Mapping):
        return None
    values = [each for value in options.values() for each in (value if type(value) in (list, tuple) else [value])]
    return repr(sorted(options.items())) if all(type(each) in SIMPLE for each in values) else None


def _bound_solver(robot: Robot, solver: str, options: Mapping[str, Any] | None) -> Single | None:
    """Return a solver with its bound operations; None if it is not compiled."""
    try:
        entry = registry().get("solver", solver)
        factory = entry.load()
        if not (isinstance(factory, type) and issubclass(factory, CompiledSolver)):
            return None
        created = entry.make(robot, entry.read_options(options or {}))
    except CdprError:
        return None  # raised again by the general function, after earlier errors
    if not speaks_for(created.compiled, created.solve):
        return None
    return Single(robot, entry, created, bool(entry.info.properties.get("respects_bounds", True)))
