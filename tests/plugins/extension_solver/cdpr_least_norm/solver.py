"""Tensions of least norm, without limits."""

from pathlib import Path

from cdpr.native.own import Own
from cdpr.plugins import CompiledSolver
from cdpr_least_norm import kernel


class LeastNorm(CompiledSolver):
    """Solver whose kernel is also exported in FMUs, as its header."""

    source = Own(Path(__file__).with_name("least_norm.hpp"), "least_norm::Problem, least_norm::solve")

    def __init__(self, robot, options):
        n = robot.n
        # The module `kernel` has the attribute `address`.
        super().__init__(robot, options, kernel, work=[(n, n), (n,)], follows=False)
