"""Benchmark of the installed tension solvers on random problems of several robots: coverage, accuracy, jumps, time.

`cdpr.analysis.bench.measures` defines the figures and `cdpr.analysis.bench.problems` the problems. Feasibility and
optimality are decided independently of the solvers under test, in `cdpr.analysis.bench.oracle`. All figures but the
timings are reproducible.
"""

from typing import TYPE_CHECKING

from cdpr.analysis.bench.benchmark import run
from cdpr.base.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["run"]
