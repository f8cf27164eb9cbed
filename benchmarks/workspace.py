"""Cost of a pose of a workspace, in units of one numpy.linalg.pinv of a 6x8 matrix in the same process."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import highspy
import numpy as np
from scipy.optimize import linprog

import cdpr
from cdpr.analysis.workspace import box, measure, region
from cdpr.mechanics.clearance import clearance
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state, wrench_matrix

try:
    from pycapacity.algorithms import hyper_plane_shift_method
except ImportError:
    hyper_plane_shift_method = None

ROBOTS = Path(__file__).parent.parent / "scenarios" / "robots"
NAMES = ("cogiro", "caroca", "ipanema_1", "planar")
POSES = 163840  # twenty chunks of a thread
PROGRAMS = 20
ROUNDS = 30
PINV_CALLS = 200
HALF = [50.0, 50.0, 50.0, 5.0, 5.0, 5.0]  # N, N m
DIAMETER = 0.01  # m
GRAVITY = (0.0, 0.0, -9.81)


def poses_of(robot: cdpr.Robot) -> np.ndarray:
    """Poses (POSES, 7) anywhere in the frame, upright."""
    here, rng = region(robot), np.random.default_rng(0)
    poses = np.zeros((POSES, 7))
    poses[:, :3] = here.lower + (here.upper - here.lower) * rng.random((POSES, 3))
    poses[:, 3] = 1.0
    return poses


class Programs:
    """Feasibility of the weight at poses, by linear programs."""

    def __init__(self, robot: cdpr.Robot, poses: np.ndarray) -> None:
        states = [make_state(pose[:3], pose[3:]) for pose in poses[:PROGRAMS]]
        self.problems = [
            (wrench_matrix(robot, state)[robot.rows], required_wrench(robot, state, GRAVITY)[robot.rows])
            for state in states
        ]
        self.limits = np.stack([robot.tension_min, robot.tension_max], axis=1)
        self.highs = highspy.Highs()
        self.highs.setOptionValue("output_flag", False)
        self.highs.setOptionValue("presolve", "off")

    def scipy(self) -> None:
        """Compute the result by scipy."""
        for W, wrench in self.problems:
            linprog(np.zeros(W.shape[1]), A_eq=W, b_eq=wrench, bounds=self.limits)

    def facets(self) -> None:
        """Compute the facets by pycapacity."""
        for W, _ in self.problems:
            hyper_plane_shift_method(W, self.limits[:, 0], self.limits[:, 1])

    def direct(self) -> None:
        """Pass each model to HiGHS, and run it."""
        for W, wrench in self.problems:
            n, m = W.shape
            model = highspy.HighsLp()
            model.num_col_, model.num_row_ = m, n
            model.col_cost_, model.row_lower_, model.row_upper_ = np.zeros(m), wrench, wrench
            model.col_lower_, model.col_upper_ = self.limits[:, 0], self.limits[:, 1]
            matrix = model.a_matrix_
            matrix.format_ = highspy.MatrixFormat.kColwise
            matrix.start_, matrix.index_ = np.arange(0, n * m + 1, n), np.tile(np.arange(n), m)
            matrix.value_ = W.ravel(order="F")
            self.highs.passModel(model)
            self.highs.run()


def measured(name: str) -> dict[str, float]:
    """All figures of a robot, pinvs a pose, and how many times as fast two threads are."""
    robot = cdpr.load_robot(ROBOTS / f"{name}.yaml")
    bare = replace(robot, platform=replace(robot.platform, shape=None))
    poses, matrix = poses_of(robot), np.random.default_rng(1).normal(size=(6, 8))
    programs, among, half = Programs(robot, poses), clearance(bare, diameter=DIAMETER), box(HALF)

    def pinvs() -> None:
        for _ in range(PINV_CALLS):
            np.linalg.pinv(matrix)

    jobs: dict[str, tuple[Callable[[], object], int]] = {
        "pinv": (pinvs, PINV_CALLS),
        "margin": (lambda: measure(robot, poses, required=half, jobs=1), POSES),
        "margin, two threads": (lambda: measure(robot, poses, required=half, jobs=2), POSES),
        "static": (lambda: measure(robot, poses, jobs=1), POSES),
        "closure": (lambda: measure(robot, poses, "closure", jobs=1), POSES),
        "clearance": (lambda: among.at(poses, 1), POSES),
        "HiGHS": (programs.direct, PROGRAMS),
        "linprog": (programs.scipy, PROGRAMS),
    }
    if hyper_plane_shift_method is not None:
        jobs["pycapacity"] = programs.facets, PROGRAMS
    least = dict.fromkeys(jobs, np.inf)
    for _ in range(ROUNDS):
        for key, (job, count) in jobs.items():
            start = perf_counter()
            job()
            least[key] = min(least[key], (perf_counter() - start) / count)
    found = {key: value / least["pinv"] for key, value in least.items() if key != "pinv"}
    found["two threads"] = found["margin"] / found.pop("margin, two threads")
    found["HiGHS over margin"] = found["HiGHS"] / found["margin"]
    return found


if __name__ == "__main__":
    table = {name: measured(name) for name in NAMES}
    if "--json" in sys.argv[1:]:
        print(json.dumps(table, indent=1))
    else:
        print(f"{'pinvs a pose':<20}" + "".join(f"{name:>12}" for name in table))
        for key in next(iter(table.values())):
            print(f"{key:<20}" + "".join(f"{table[name][key]:>12.3g}" for name in table))
