"""Benchmark of the installed tension solvers on random problems of several robots: coverage, accuracy, jumps, time.

    from cdpr import bench
    from cdpr.scenario import load_robot

    figures = bench.run([load_robot("robot.yaml")], solvers=["qp"], poses=500, seed=1)

`cdpr.bench.measures` defines the figures and `cdpr.bench.problems` the problems. Feasibility and optimality are decided
independently of the solvers under test, in `cdpr.bench.oracle`. All figures but the timings are reproducible.
"""

from typing import TYPE_CHECKING

from cdpr.bench.benchmark import run
from cdpr.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["run"]
