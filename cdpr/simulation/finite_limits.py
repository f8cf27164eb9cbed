"""Solvers that require finite tension limits."""

from __future__ import annotations

import numpy as np

from cdpr.base.errors import ScenarioError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension.status import Status

REFUSED = (Status.UNSUPPORTED, Status.BAD_INPUT)

# Highest tension instead of an infinite one, as a multiple of the wrench: far from binding.
FAR = 100.0


def check_limits(robot: Robot, solver: TensionSolver, name: str, limits: Array, W: Array, wrench: Array) -> None:
    """Check that a solver that refuses infinite limits (2, m), N, does not get them.

    Args:
        robot: robot whose degrees of freedom are the directions of the distribution.
        solver: the solver.
        name: its name.
        limits: lowest and highest tensions, (2, m), N.
        W: wrench matrix, (6, m), 1 and m.
        wrench: required wrench, (6,), N and N m.

    Raises:
        ScenarioError: if it refuses them, but not finite ones.
    """
    low, high = np.array(limits)
    if np.isfinite(high).all():
        return
    rows = robot.rows
    finite = np.where(np.isfinite(high), high, np.abs(low) + FAR * (1.0 + np.abs(wrench).max()))
    try:
        given, other = (
            solver.solve(W[rows], wrench[rows], low, each, np.full(robot.m, np.nan)) for each in (high, finite)
        )
    except Exception:  # third-party code: the tension stage reports it
        return
    if given in REFUSED and other not in REFUSED:
        text = f"solver '{name}' requires finite limits of all tensions: give tension_max, or another solver such as qp"
        raise ScenarioError([f"robot.tension.max: {text}"])
