"""Distributing one wrench or a million: arrays in, arrays out, on all cores."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.errors import CdprError
from cdpr.model import Robot, dynamics, kernels
from cdpr.model.robot import Array
from cdpr.tension import box_least_squares as box
from cdpr.tension.policy import action
from cdpr.tension.stage import TensionStage
from cdpr.tension.status import BAD_INPUT

if TYPE_CHECKING:
    from cdpr.plugins import TensionSolver

# Rows that a thread takes at a time: some milliseconds of work, so that all cores are busy until the end.
CHUNK = 4096

UNIT_TOLERANCE = 1e-3  # of a quaternion's length: rounded input is nearer to 1, mistakes are farther


@dataclass(frozen=True, eq=False)
class Distribution:
    """K distributions for a robot with m cables; of a single one, the leading axis is missing."""

    tension: Array  # (K, m), N, within the limits; NaN where the input was bad
    status: Array  # (K,), `cdpr.tension.Status` of the solver's answer after the checks
    residual: Array  # (K,), N, |W t - wrench|, moments divided by the characteristic length
    margin: Array  # (K,), N, smallest distance of a tension from its limits
    at_limit: Array  # (K,), number of cables at a limit

    @property
    def feasible(self) -> Array:
        """Whether the tensions balance the wrench within the limits, (K,)."""
        return np.asarray(self.status == 0.0)


def distribute(
    robot: Robot,
    poses: ArrayLike,
    wrenches: ArrayLike | None = None,
    *,
    solver: str | TensionSolver = "qp",
    options: Mapping[str, Any] | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
    jobs: int | None = None,
) -> Distribution:
    """Distribute wrenches at poses, each row by itself, as the tension stage of a run does.

    Args:
        robot: gives geometry, limits and degrees of freedom.
        poses: (7,) or (K, 7): position (m) and quaternion w, x, y, z of the platform.
        wrenches: (6,) or (K, 6): what the cables are to exert on the platform at its origin (N, N m, world axes); by
            default what holds the platform still against `gravity`.
        solver: the name of an installed solver, or one made for this robot.
        options: options of a solver given by name.
        gravity: (3,), m/s^2, world.
        jobs: threads for a compiled solver, by default one per core; the result is the same. Others use one.

    A row with an entry that is not finite gets the status BAD_INPUT. Where no distribution is admissible the tensions
    are those within the limits that come nearest to the wrench, and the status says so. To a solver whose answers
    depend on the step before, each row is a first step.

    Raises:
        CdprError: shapes do not fit, or a quaternion has not length 1.
        PluginError: the solver is unknown, not installed, refuses its options or the robot, or raises.
    """
    single = np.ndim(poses) < 2 and (wrenches is None or np.ndim(wrenches) < 2)
    pose = _table(poses, 7, "poses")
    wrench = np.empty((0, 6)) if wrenches is None else _table(wrenches, 6, "wrenches")
    count = len(pose) if wrenches is None or len(pose) != 1 else len(wrench)
    if wrenches is not None and len(wrench) not in (1, count):
        raise CdprError(f"wrenches: {len(wrench)} rows for {count} poses; give one of either, or as many")
    length = np.sqrt(np.einsum("ki,ki->k", pose[:, 3:], pose[:, 3:]))
    if (off := np.flatnonzero(np.abs(length - 1.0) > UNIT_TOLERANCE)).size:
        raise CdprError(f"poses[{off[0]}]: the quaternion has length {length[off[0]]:.6g}, it must be 1")
    if len(pose) < count:
        pose = np.repeat(pose, count, axis=0)
    if 0 < len(wrench) < count:
        wrench = np.repeat(wrench, count, axis=0)
    down = _table(gravity, 3, "gravity")[0]
    respects_bounds = True
    chosen: Any = solver
    if isinstance(solver, str):
        from cdpr.plugins.registry import registry

        entry = registry().get("solver", solver)
        respects_bounds = bool(entry.info.properties.get("respects_bounds", True))
        chosen = entry.make(robot, entry.read_options(options or {}))
    tension, report = np.empty((count, robot.m)), np.empty((count, 4))
    run = _compiled if getattr(chosen, "kernel", None) else _row_by_row
    run(robot, chosen, respects_bounds, down, pose, wrench, tension, report, jobs or len(os.sched_getaffinity(0)))
    columns = (tension, *report.T)
    return Distribution(*(column[0] if single else column for column in columns))


def _table(values: ArrayLike, width: int, name: str) -> Array:
    try:
        array = np.require(values, np.float64, ["C", "W"])  # a million rows are not copied without need
    except (TypeError, ValueError) as error:
        raise CdprError(f"{name}: numbers are expected: {error}") from error
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        raise CdprError(f"{name}: the shape must be ({width},) or (K, {width}), got {array.shape}")
    return array.reshape(-1, width)


def _compiled(
    robot: Robot,
    solver: Any,
    respects_bounds: bool,
    gravity: Array,
    pose: Array,
    wrench: Array,
    tension: Array,
    report: Array,
    jobs: int,
) -> None:
    """Fill tension and report by a solver's kernel, in threads: it takes no lock, and rows are independent."""
    from cdpr.tension.batch import distribute_rows

    weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows]
    limits = np.array([robot.tension_min, robot.tension_max])
    spare = box.work_rows(robot.n, robot.m), max(robot.n, robot.m)
    fixed = (
        solver.kernel,
        solver.parameters,
        solver.work.shape,
        spare,
        action("best_effort", respects_bounds),
        robot.anchors.copy(),
        np.array(robot.rows),
        robot.inertial.copy(),
        gravity,
        weights,
        limits,
    )

    def part(start: int) -> None:
        rows = slice(start, start + CHUNK)
        distribute_rows(*fixed, pose[rows], wrench[rows], tension[rows], report[rows])

    starts = range(0, len(pose), CHUNK)
    if jobs == 1 or len(starts) == 1:
        for start in starts:
            part(start)
        return
    with ThreadPoolExecutor(jobs) as threads:
        for _ in threads.map(part, starts):
            pass


def _row_by_row(
    robot: Robot,
    solver: TensionSolver,
    respects_bounds: bool,
    gravity: Array,
    pose: Array,
    wrench: Array,
    tension: Array,
    report: Array,
    jobs: int,
) -> None:
    """Fill tension and report by a solver that is Python."""
    m = robot.m
    W, w, t, row, spare = np.zeros((6, m)), np.zeros(6), np.zeros(m), np.zeros(4), np.zeros(m)
    state = np.zeros(13)
    name = type(solver).__name__
    stage = TensionStage(robot, solver.solve, name, respects_bounds, "best_effort", W, w, t, row)
    for k, at in enumerate(pose):
        state[:7] = at
        state[3:7] /= np.linalg.norm(at[3:])
        kernels.cable_geometry(robot.anchors, state, W, spare, spare)
        w[:] = wrench[k] if len(wrench) else dynamics.required_wrench(robot, state, gravity)
        stage.forget()
        tension[k], report[k] = np.nan, (BAD_INPUT, np.nan, np.nan, np.nan)
        if np.isfinite(W).all() and np.isfinite(w).all():
            stage.distribute()
            tension[k], report[k] = t, row
