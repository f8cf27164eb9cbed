"""Compares the installed tension solvers on random problems of several robots: coverage, accuracy, jumps, time.

    from cdpr import bench
    from cdpr.scenario import load_robot

    figures = bench.run([load_robot("robot.yaml")], solvers=["qp"], poses=500, seed=1)

What each figure means is said in `cdpr.bench.measures`; the problems are those of `cdpr.bench.problems`, and what is
feasible or optimal is decided by other means than the solvers', in `cdpr.bench.oracle`. All figures but the timings are
the same each time.
"""

from typing import TYPE_CHECKING

from cdpr.bench.benchmark import run
from cdpr.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["run"]
