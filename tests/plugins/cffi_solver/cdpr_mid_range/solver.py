"""Tensions nearest to the middle of their limits."""

from cdpr.plugins import CompiledSolver
from cdpr_mid_range.kernel import ffi, lib

KERNEL = int(ffi.cast("intptr_t", ffi.addressof(lib, "mid_range")))


class MidRange(CompiledSolver):
    """Solver whose kernel needs two work arrays."""

    def __init__(self, robot, options):
        n, m = robot.n, robot.m
        super().__init__(robot, options, KERNEL, work=[(n, m), (n,)], follows=False)
