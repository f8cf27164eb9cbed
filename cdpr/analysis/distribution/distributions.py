"""Distribution of one or many wrenches with array arguments, on all cores."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral
from threading import RLock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel

from cdpr.analysis.distribution.batch import Batch, Rows
from cdpr.analysis.distribution.single import distribute_single
from cdpr.analysis.distribution.source import DOWN, options_of, robot_and_gravity
from cdpr.base import tolerances
from cdpr.base.defaults import SOLVER
from cdpr.base.errors import CdprError, PluginError
from cdpr.base.problems import shown
from cdpr.base.threads import in_threads
from cdpr.cables.tables import line_table
from cdpr.mechanics import dynamics
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.bind import bind
from cdpr.plugins import CompiledSolver, TensionSolver
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.registry import registry
from cdpr.scenario.loader import AnyRobot, robot_or_scenario
from cdpr.tension import Status
from cdpr.tension.current_sample import Present
from cdpr.tension.stage import StageSolver, TensionStage
from cdpr.tension.status_array import StatusArray

# Rows per thread and task: some milliseconds of work, for an even load.
CHUNK = 4096

CODES = frozenset(map(float, Status))

# Number of rows from which solving eight at once saves more than binding its operations costs.
MANY = 512

# Python solvers given as objects handle one caller at a time: two threads may share the same object.
_USED = RLock()  # reentrant: a solver may itself distribute


@dataclass(frozen=True, eq=False)
class Distribution:
    """K distributions for a robot with m cables; for a single one, without the leading axis."""

    tension: Array  # (K, m), N, within the limits; NaN for bad input
    status: Any  # (K,), checked `cdpr.tension.Status` of the solver: integers that print as names
    residual: Array  # (K,), N, |W t - wrench|, moments divided by the characteristic length
    margin: Array  # (K,), N, smallest distance of a tension from its limits
    at_limit: Array  # (K,), number of cables at a limit

    @property
    def feasible(self) -> Array:
        """True if the tensions balance the wrench within the limits, (K,)."""
        return np.asarray(self.status == Status.OK)


def distribute(
    robot: AnyRobot,
    poses: ArrayLike,
    wrenches: ArrayLike | None = None,
    *,
    solver: str | TensionSolver = SOLVER,
    options: Mapping[str, Any] | None = None,
    gravity: ArrayLike | None = None,
    tension_min: ArrayLike | None = None,
    tension_max: ArrayLike | None = None,
    jobs: int | None = None,
) -> Distribution:
    """Distribute wrenches at poses, each row independently, like the tension stage of a run.

    Arguments with one row apply to all rows; if all have one dimension, so has the result. Rows with a non-finite
    entry, or a lower limit above the upper one, get the status BAD_INPUT (limits may be infinite). Without an
    admissible distribution, the tensions are those within the limits closest to the wrench, and the status reports it.
    For solvers with memory, each row is a first step.

    Args:
        robot: geometry, limits and degrees of freedom: a Robot, a file, the name of an example, a dict or a Scenario,
            whose controlled directions and gravity apply.
        poses: (7,) or (K, 7), position (m) and quaternion w, x, y, z of the platform.
        wrenches: (6,) or (K, 6), wrenches of the cables on the platform at its origin (N, N m, world axes); by default
            the wrenches that balance `gravity` at rest.
        solver: name of an installed solver, or a solver object for this robot.
        options: options of a solver given by name; by default the scenario's, if this is its solver.
        gravity: (3,), m/s^2, world; by default the scenario's, or the earth's.
        tension_min: (m,) or (K, m), N, lowest tensions instead of the robot's.
        tension_max: (m,) or (K, m), N, highest tensions instead of the robot's.
        jobs: threads for a compiled solver, at least 1, by default one per core; the result is the same. Others use
            one.

    Returns:
        Tensions, statuses and figures of each row; see `Distribution`.

    Raises:
        CdprError: if an argument has the wrong type, shapes do not match, a quaternion does not have length 1, or a
            lower limit is negative, though the robot's cables can only pull.
        PluginError: if the solver is unknown, not installed, rejects its options or the robot, or raises.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> one = cdpr.distribute(robot, robot.home)
        >>> one.status, one.tension.shape
        (<Status.OK: 0>, (8,))
        >>> many = cdpr.distribute(robot, robot.home, [[0.0, 0.0, force, 0.0, 0.0, 0.0] for force in (1500.0, 1e6)])
        >>> many.feasible
        array([ True, False])
    """
    loaded = robot if type(robot) is Robot else robot_or_scenario(robot)
    robot, gravity = robot_and_gravity(loaded, gravity)
    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, Integral) or jobs < 1):
        raise CdprError(f"jobs: expected a whole number of threads, at least 1, got {shown(jobs)}")
    if isinstance(solver, str) and gravity is DOWN:
        one = distribute_single(robot, solver, options, (poses, wrenches, tension_min, tension_max), gravity)
        if one is not None:
            tension, (code, *figures) = one
            rest: tuple[Any, ...] = tuple(map(np.float64, figures))
            if code not in CODES:
                _check_statuses(np.array([code]), solver)
            return Distribution(tension, Status(int(code)), *rest)
    own = options_of(loaded, solver) if options is None else None
    chosen, respects_bounds = _solver(robot, solver, options, own)
    pose = _rows(poses, 7, "poses")
    wrench = None if wrenches is None else _rows(wrenches, 6, "wrenches")
    low = _rows(robot.tension_min if tension_min is None else tension_min, robot.m, "tension_min")
    high = _rows(robot.tension_max if tension_max is None else tension_max, robot.m, "tension_max")
    if robot.unilateral and (low < 0.0).any():
        raise CdprError("tension_min: below zero, but cables cannot push; only a robot of `unilateral: false` may")
    count = _count({"poses": pose, "wrenches": wrench, "tension_min": low, "tension_max": high})
    check_unit(pose, "poses")
    arguments = (poses, wrenches, tension_min, tension_max)
    single = all(np.ndim(values) < 2 for values in arguments if values is not None)
    limits = np.ascontiguousarray(np.stack(np.broadcast_arrays(low, high), axis=1))
    task = _Task(
        robot=robot,
        solver=chosen,
        respects_bounds=respects_bounds,
        gravity=checked(gravity, (3,), "gravity"),
        pose=_repeated(pose, count),
        wrench=None if wrench is None else _repeated(wrench, count),
        limits=limits if len(limits) == 1 else _repeated(limits, count),
        tension=np.empty((count, robot.m)),
        report=np.empty((count, 4)),
    )
    if isinstance(chosen, CompiledSolver) and speaks_for(chosen.compiled, chosen.solve):
        _compiled(task, len(os.sched_getaffinity(0)) if jobs is None else int(jobs))
    elif isinstance(solver, str):
        _row_by_row(task)
    else:  # another thread may use it, and it has a work space
        with _USED:
            _row_by_row(task)
    status, residual, margin, at_limit = task.report.T
    _check_statuses(status, solver)
    columns: tuple[Any, ...] = (task.tension, StatusArray(status), residual, margin, at_limit)
    return Distribution(*(column[0] if single else column for column in columns))


def _check_statuses(codes: Array, solver: object) -> None:
    """Raise PluginError if a compiled solver returned a code that is not a status."""
    unknown = codes[~np.isin(codes, list(Status))]
    if len(unknown):
        name = solver if isinstance(solver, str) else type(solver).__name__
        raise PluginError(f"solver '{name}' returned {unknown[0]:g}, which is not a cdpr.tension.Status")


def _solver(
    robot: Robot, solver: Any, options: Mapping[str, Any] | None, own: BaseModel | None
) -> tuple[TensionSolver, bool]:
    """Return the solver, and True if it declares that it respects the limits; `own` are checked options."""
    if options is not None and not isinstance(options, Mapping):
        raise CdprError(f"options: expected a mapping of names to values, got {shown(options)}")
    if isinstance(solver, str):
        entry = registry().get("solver", solver)
        created = entry.make(robot, own or entry.read_options(options or {}))
        return created, _respects_bounds(entry.info.properties)
    if not isinstance(solver, TensionSolver):
        given = f"the class {solver.__name__}" if isinstance(solver, type) else f"a {type(solver).__name__}"
        raise CdprError(f"solver: expected the name of a solver, or a TensionSolver of this robot, got {given}")
    if options is not None:
        raise CdprError("options: allowed only with the name of a solver; a solver object already has its options")
    if (solver.robot.n, solver.robot.m) != (robot.n, robot.m):
        raise CdprError(
            f"solver: was made for a robot with {solver.robot.m} cables and {solver.robot.n} degrees of freedom, this "
            f"one has {robot.m} and {robot.n}"
        )
    return solver, _respects_bounds(registry().declared("solver", type(solver)))


def _respects_bounds(properties: Mapping[str, object]) -> bool:
    return bool(properties.get("respects_bounds", True))


def _rows(values: ArrayLike, width: int, name: str) -> Array:
    array = real(values, name)  # large arrays are copied only if necessary
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        of = " (position and quaternion w, x, y, z)" if name == "poses" else ""
        raise CdprError(f"{name}: the shape must be ({width},) or (K, {width}){of}, got {array.shape}")
    return array.reshape(-1, width)


def _count(given: Mapping[str, Array | None]) -> int:
    """Return the number of rows of the result."""
    rows = {name: len(array) for name, array in given.items() if array is not None}
    several = {name: count for name, count in rows.items() if count != 1}
    if len(set(several.values())) > 1:
        counts = ", ".join(f"{name} {count}" for name, count in several.items())
        raise CdprError(f"rows: {counts}; give either one row or equal numbers of rows")
    return next(iter(several.values()), 1)


def check_unit(pose: Array, name: str) -> None:
    """Raise CdprError if a quaternion of poses (K, 7) does not have length 1."""
    length = np.sqrt(np.einsum("ki,ki->k", pose[:, 3:], pose[:, 3:]))
    if (off := np.flatnonzero(np.abs(length - 1.0) > tolerances.UNIT)).size:
        which = f"{name}[{off[0]}]" if name.endswith("s") else name
        raise CdprError(f"{which}: expected a quaternion of norm 1, got norm {length[off[0]]:.6g}")


def _repeated(array: Array, count: int) -> Array:
    """Return a single row repeated, or all rows unchanged."""
    return np.repeat(array, count, axis=0) if len(array) == 1 and count != 1 else array


@dataclass(frozen=True, eq=False)
class _Task:
    """K rows to distribute, and the arrays of their results."""

    robot: Robot
    solver: TensionSolver
    respects_bounds: bool
    gravity: Array  # (3,)
    pose: Array  # (K, 7)
    wrench: Array | None  # (K, 6); None: static wrench
    limits: Array  # (K, 2, m), or (1, 2, m) for all rows
    tension: Array  # (K, m), written
    report: Array  # (K, 4), written


def _compiled(task: _Task, jobs: int) -> None:
    """Write tensions and reports by compiled operations in parallel threads; rows are independent."""
    assert isinstance(task.solver, CompiledSolver)
    batch = Batch(task.robot, task.gravity, task.solver, task.respects_bounds)
    wrench = np.empty((0, 6)) if task.wrench is None else task.wrench

    def part(rows: slice) -> None:
        limits = task.limits if len(task.limits) == 1 else task.limits[rows]
        given = Rows.of(limits, task.pose[rows], wrench[rows], task.tension[rows], task.report[rows])
        side_by_side = batch.bind_side_by_side(given) if len(given.poses) >= MANY else None
        if side_by_side is not None:
            side_by_side.distribute()
        batch.bind(given).distribute()

    in_threads(len(task.pose), part, jobs, CHUNK)


def _row_by_row(task: _Task) -> None:
    """Write tensions and reports with a Python solver."""
    robot, m = task.robot, task.robot.m
    live, state, spare = Present.of(m), np.zeros(13), {"length": np.zeros(m), "rate": np.zeros(m)}
    geometry = bind("geometry", lines=line_table(robot), state=state, matrix=live.W, **spare)
    stage = TensionStage(robot, StageSolver(task.solver.solve, type(task.solver).__name__, task.respects_bounds), live)
    task.tension[:], task.report[:] = np.nan, (Status.BAD_INPUT, np.nan, np.nan, np.nan)
    for k, at in enumerate(task.pose):
        state[:7] = at
        state[3:7] /= np.linalg.norm(at[3:])
        geometry()
        given = task.wrench
        live.wrench[:] = dynamics.required_wrench(robot, state, task.gravity) if given is None else given[k]
        stage.cables.limits[:] = low, high = task.limits[k if len(task.limits) > 1 else 0]
        stage.forget()
        if np.isfinite(live.W).all() and np.isfinite(live.wrench).all() and (low <= high).all():
            stage.distribute()
            task.tension[k], task.report[k] = live.tension, live.report
