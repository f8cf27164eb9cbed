"""Cost of a row of cdpr.distribute, in units of one numpy.linalg.pinv of a 6x8 matrix in the same process."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

import cdpr
from cdpr.plugins.registry import registry

ROBOT = Path(__file__).parent.parent / "scenarios" / "robots" / "caroca.yaml"
ROWS = 131072
ROUNDS = 20
PINV_CALLS = 200
HELD = 400.0  # N: lowest tensions beyond what hangs there needs, so that each row has cables at a limit


def measure() -> dict[str, float]:
    """All figures: pinvs a row, and how many times as fast two threads are."""
    robot, rng = cdpr.load_robot(ROBOT), np.random.default_rng(1)
    poses = np.tile([0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0], (ROWS, 1))
    poses[:, :3] += rng.uniform(-0.5, 0.5, (ROWS, 3))
    matrix = rng.normal(size=(6, 8))
    entry = registry().get("solver", "qp")
    solver, single = (entry.make(robot, entry.read_options({})) for _ in range(2))
    single.side_by_side = lambda *arrays: None
    few, at_limits = poses[: ROWS // 4], {"tension_min": np.full(robot.m, HELD)}

    def pinvs() -> None:
        for _ in range(PINV_CALLS):
            np.linalg.pinv(matrix)

    calls: dict[str, tuple[Callable[[], object], int]] = {
        "pinv": (pinvs, PINV_CALLS),
        "row": (lambda: cdpr.distribute(robot, poses, solver=solver, jobs=1), ROWS),
        "row_alone": (lambda: cdpr.distribute(robot, few, solver=single, jobs=1), len(few)),
        "row_at_limits": (lambda: cdpr.distribute(robot, few, solver=solver, jobs=1, **at_limits), len(few)),
        "row_at_limits_alone": (lambda: cdpr.distribute(robot, few, solver=single, jobs=1, **at_limits), len(few)),
        "two": (lambda: cdpr.distribute(robot, poses, solver=solver, jobs=2), ROWS),
    }
    least = dict.fromkeys(calls, np.inf)
    for turn in range(ROUNDS + 1):
        for name, (call, count) in calls.items():
            start = perf_counter()
            call()
            if turn:
                least[name] = min(least[name], (perf_counter() - start) / count)
    pinv, two = least.pop("pinv"), least.pop("two")
    return {**{name: float(value / pinv) for name, value in least.items()}, "two_cores": float(least["row"] / two)}


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=2))
    else:
        for name, value in figures.items():
            print(f"{name:<22}{value:.4f}" + (" times as fast" if name == "two_cores" else " pinv"))
