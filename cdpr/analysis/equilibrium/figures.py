"""Equilibria and compensated lengths as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.analysis.equilibrium.compensation import Compensation
from cdpr.mechanics.equilibrium import Equilibrium
from cdpr.mechanics.exit_friction import friction_note
from cdpr.model import Robot
from cdpr.model.robot import Array


def describe_equilibrium(robot: Robot, found: Equilibrium) -> dict[str, Any]:
    """Return an equilibrium of a robot as plain data."""
    cables = [
        {
            "name": cable.name,
            "tension_N": float(found.tension[i]),
            "length_m": float(found.length[i]),
            "unwound_m": float(found.unwound[i]),
            "slack": bool(found.slack[i]),
            "above_limit": bool(found.tension[i] > cable.tension_max),
            "sensitivity": found.sensitivity[:, i].tolist(),
        }
        for i, cable in enumerate(robot.cables)
    ]
    return {
        "pose": _pose(found.pose),
        "converged": found.converged,
        "problem": found.problem,
        "suspect": None if found.suspect is None else robot.cables[found.suspect].name,
        "residual_N": found.residual,
        "load_N": found.load,
        "misfit_m": found.misfit,
        "stability": found.stability,
        "eigenvalues_N_per_m": found.eigenvalues.tolist(),
        "frequencies_Hz": [None if np.isnan(value) else float(value) for value in found.frequencies],
        "free_directions": found.free_directions.tolist(),
        "cables": cables,
    }


def describe_equilibria(robot: Robot, source: str, found: Sequence[Equilibrium]) -> dict[str, Any]:
    """Return the equilibria of a robot as plain data; `source` names the origin of the start."""
    return {
        "robot": robot.name,
        "dof": list(robot.dof),
        "start": source,
        "equilibria": [describe_equilibrium(robot, one) for one in found],
        "friction": friction_note(robot),
    }


def describe_compensation(robot: Robot, pose: Array, found: Compensation, held: Equilibrium) -> dict[str, Any]:
    """Return compensated lengths at one pose as plain data; `held` is the rest without compensation."""
    cables = [
        {
            "name": cable.name,
            "length_m": float(found.lengths[i]),
            "path_m": float(held.unwound[i]),
            "tension_N": float(found.tension[i]),
        }
        for i, cable in enumerate(robot.cables)
    ]
    return {
        "robot": robot.name,
        "pose": _pose(pose),
        "status": found.status.name,
        "feasible": bool(found.feasible),
        "cables": cables,
        "uncompensated": {
            "pose": _pose(held.pose),
            "error_m": float(np.linalg.norm(held.pose[:3] - pose[:3])),
            "converged": held.converged,
            "slack": [cable.name for cable, slack in zip(robot.cables, held.slack, strict=True) if slack],
        },
        "friction": friction_note(robot),
    }


def _pose(pose: Array) -> dict[str, list[float]]:
    return {"position_m": pose[:3].tolist(), "orientation_wxyz": pose[3:].tolist()}
