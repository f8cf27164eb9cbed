"""Figures of the tension solvers: costs as ratios within one run, and answers against independent oracles.

Run: python benchmarks/solvers.py [--problems 100000] [--paths 1000]. The table of all solvers: cdpr bench solvers.
"""

from __future__ import annotations

import argparse
import gc
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter_ns

import distribute
import numpy as np

import cdpr
from cdpr.analysis.bench import measures
from cdpr.analysis.bench.oracle import consult
from cdpr.analysis.bench.problems import make_paths, make_problems
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.plugins.registry import registry
from cdpr.tension.current_sample import Present
from cdpr.tension.stage import StageSolver, TensionStage
from cdpr.tension.status import OK

ROBOTS = Path(__file__).parent.parent / "scenarios" / "robots"
CALLS = 4000
ROBOTS_ASKED = ("caroca", "thesis", "planar", "point_mass", "seven", "crossed", "nine", "twelve")


def medians(functions: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Median microseconds of each, called in turn so that all meet the same disturbances."""
    times: dict[str, list[int]] = {name: [] for name in functions}
    for function in functions.values():
        function()
    gc.disable()
    for _ in range(CALLS):
        for name, function in functions.items():
            function()  # what came before has left its traces in the caches
            started = perf_counter_ns()
            function()
            times[name].append(perf_counter_ns() - started)
    gc.enable()
    return {name: float(np.median(values)) / 1e3 for name, values in times.items()}


def costs() -> None:
    caroca, twelve = (cdpr.load_robot(ROBOTS / f"{name}.yaml") for name in ("caroca", "twelve"))
    matrix = np.random.default_rng(0).normal(size=(6, 8))
    functions: dict[str, Callable[[], object]] = {"pinv": lambda: np.linalg.pinv(matrix)}

    for label, robot in (("", caroca), ("12 cables, ", twelve)):
        W, wrench = feasible(robot)
        given = [read_only(array) for array in (W, wrench, robot.tension_min, robot.tension_max)]
        for name in ("qp", "daqp"):
            tension, solve = np.zeros(robot.m), make(name, robot).solve
            functions[f"{label}{name}"] = lambda solve=solve, given=given, tension=tension: solve(*given, tension)
    for label, scale in (("qp with the stage's checks", 1.0), ("infeasible, answered by the policy", 100.0)):
        live = Present.of(caroca.m)
        live.W[:], live.wrench[:] = feasible(caroca)
        live.wrench *= scale
        stage = TensionStage(caroca, StageSolver(make("qp", caroca).solve, "qp"), live)
        functions[label] = stage.distribute
    found = medians(functions)
    for name, value in found.items():
        print(f"{name:36} {value:8.2f} us  {value / found['pinv']:.3f} pinv")
    print(
        f"daqp / qp: {found['daqp'] / found['qp']:.1f}, "
        f"with 12 cables: {found['12 cables, daqp'] / found['12 cables, qp']:.1f}"
    )
    rows = distribute.measure()
    print(f"batch, one core: {rows['row']:.4f} pinv a row; two cores: {rows['two_cores']:.2f} times as fast")


def make(name: str, robot: Robot):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options({}))


def feasible(robot: Robot) -> tuple[Array, Array]:
    """The first of the benchmark's problems that has an answer."""
    problems, solver, tension = make_problems(robot, 50, 1), make("qp", robot), np.zeros(robot.m)
    for W, wrench in zip(problems.W, problems.wrench, strict=True):
        if solver.solve(W, wrench, robot.tension_min, robot.tension_max, tension) == 0:
            return W.copy(), wrench.copy()
    raise SystemExit("no problem of this robot is feasible")


def misclassified(count: int) -> None:
    """Solve the problems decided by HiGHS with the exact solvers."""
    wrong, decided = dict.fromkeys(("qp", "lp", "analytic_centre"), 0), 0
    for name in ROBOTS_ASKED:
        robot = cdpr.load_robot(ROBOTS / f"{name}.yaml")
        problems = make_problems(robot, count // len(ROBOTS_ASKED), 2)
        truth, tension = consult(problems), np.zeros(robot.m)
        decided += int(truth.feasible.sum() + truth.infeasible.sum())
        for solver_name in wrong:
            solver = make(solver_name, robot)
            for k, (W, wrench) in enumerate(zip(problems.W, problems.wrench, strict=True)):
                ok = solver.solve(W, wrench, robot.tension_min, robot.tension_max, tension) == 0
                wrong[solver_name] += bool((ok and truth.infeasible[k]) or (not ok and truth.feasible[k]))
    print(f"misclassified of {decided} problems that HiGHS decides: {wrong}")


def jumps(count: int) -> None:
    """Look for jumps along random paths, of all robots together `count`."""
    for name in ("qp", "analytic_centre"):
        paths, broken = 0, 0
        for robot_name in ROBOTS_ASKED:
            robot = cdpr.load_robot(ROBOTS / f"{robot_name}.yaml")
            solver = make(name, robot)

            def tension(path: measures.Path, s: float, solver=solver, robot=robot) -> Array | None:
                W, wrench = path.at(s)
                t = np.full(robot.m, np.nan)
                return t if solver.solve(W, wrench, robot.tension_min, robot.tension_max, t) == OK else None

            found = measures.jumps(make_paths(robot, count // len(ROBOTS_ASKED), 3), tension)
            paths, broken = paths + found["paths"], broken + found["with_jump"]
        print(f"{name}: tensions jump on {broken} of {paths} paths")


FIRST_CALL = """
from time import perf_counter
started = perf_counter()
import cdpr
robot = cdpr.load_robot({robot!r})
cdpr.distribute(robot, [0, 0, 1.2, 1, 0, 0, 0])
print(perf_counter() - started)
"""


def first_call() -> None:
    """Time the first distribution of a process alone."""
    program = FIRST_CALL.format(robot=str(ROBOTS / "caroca.yaml"))
    seconds = [
        float(subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout)
        for _ in range(6)
    ][1:]
    print(f"first call : {np.median(seconds):.2f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--problems", type=int, default=0, help="number of problems to compare with HiGHS")
    parser.add_argument("--paths", type=int, default=0, help="number of random paths to search for jumps")
    arguments = parser.parse_args()
    costs()
    first_call()
    if arguments.problems:
        misclassified(arguments.problems)
    if arguments.paths:
        jumps(arguments.paths)
