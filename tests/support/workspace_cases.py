"""Shared cases of tests of workspaces in chunks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from command_line import cdpr_here
from conftest import GRAVITY, ROOT

from cdpr import load_robot
from cdpr.analysis.jobs.folder import LEDGER_NAME
from cdpr.analysis.workspace.regions import region
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state, wrench_matrix

ROBOTS = ROOT / "scenarios" / "robots"


def cli(*words):
    return cdpr_here(*words, code=None)


def robot_of(name):
    return load_robot(ROBOTS / f"{name}.yaml")


def poses_of(robot, count, seed=0):
    """In the frame, a little turned where the platform can turn."""
    rng = np.random.default_rng(seed)
    box = region(robot)
    poses = np.zeros((count, 7))
    poses[:, :3] = box.lower + (box.upper - box.lower) * rng.random((count, 3))
    q = np.concatenate([np.ones((count, 1)), np.zeros((count, 3))], axis=1)
    for i, name in enumerate(("rx", "ry", "rz")):
        if name in robot.dof:
            q[:, 1 + i] = 0.1 * rng.standard_normal(count)
    poses[:, 3:] = q / np.linalg.norm(q, axis=1)[:, None]
    return poses


def problem(robot, pose):
    """W (n, m) and the wrench that carries the weight, moments divided by the characteristic length."""
    weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows]
    state = make_state(pose[:3], pose[3:])
    W = weights[:, None] * wrench_matrix(robot, state)[robot.rows]
    return W, weights * required_wrench(robot, state, GRAVITY)[robot.rows], weights


def content(folder: Path) -> dict[str, object]:
    """All that a folder of chunks holds, to the byte, but for the order in which they came."""
    files = {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    return {**files, LEDGER_NAME: sorted(set(files[LEDGER_NAME].splitlines()))}
