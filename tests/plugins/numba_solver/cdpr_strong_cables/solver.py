"""Least sum of (t_i / t_max_i)^2 with W t = wrench, by orthogonal rows (modified Gram-Schmidt)."""

import math
from functools import lru_cache

import numba
from numba import types

from cdpr.plugins import CompiledSolver
from cdpr.tension.status import NOT_FOUND, OK

PLACE = types.CPointer(types.CPointer(types.float64))  # the struct, as an array of pointers
DEPENDENT = 1e-18  # of a row's square: what is left of one that depends on those before
ROUND_OFF = 1e-12  # of the wrench: what such a row may miss


def distribute(W, wrench, high, tension, rows, share):
    """Write the tensions (m,); return a status. `rows` (n, m) and `share` (n,) are work arrays."""
    n, m = W.shape
    scale = 0.0
    for k in range(n):
        scale += abs(wrench[k])
    tension[:] = 0.0
    for k in range(n):
        share[k] = wrench[k]
        whole, left = 0.0, 0.0
        for i in range(m):
            rows[k, i] = W[k, i] * high[i]
            whole += rows[k, i] * rows[k, i]
        for j in range(k):
            along = 0.0
            for i in range(m):
                along += rows[k, i] * rows[j, i]
            for i in range(m):
                rows[k, i] -= along * rows[j, i]
            share[k] -= along * share[j]
        for i in range(m):
            left += rows[k, i] * rows[k, i]
        if not left > DEPENDENT * whole:
            if not abs(share[k]) <= ROUND_OFF * scale:
                return NOT_FOUND
            rows[k], share[k] = 0.0, 0.0
            continue
        length = math.sqrt(left)
        share[k] /= length
        for i in range(m):
            rows[k, i] /= length
            tension[i] += share[k] * rows[k, i] * high[i]
    for i in range(m):
        if not math.isfinite(tension[i]):
            return NOT_FOUND
    return OK


compiled = numba.njit(distribute)


@lru_cache
def kernel(n, m):
    """Compile the kernel for n degrees of freedom and m cables."""

    @numba.cfunc(types.int32(PLACE, types.float64))
    def strong_cables(place, time):
        W, rows = numba.carray(place[0], (n, m)), numba.carray(place[7], (n, m))
        wrench, share = numba.carray(place[1], n), numba.carray(place[8], n)
        high, tension = numba.carray(place[3], m), numba.carray(place[4], m)
        return compiled(W, wrench, high, tension, rows, share)

    return strong_cables


class StrongCables(CompiledSolver):
    """Solver whose kernel needs two work arrays."""

    def __init__(self, robot, options):
        n, m = robot.n, robot.m
        super().__init__(robot, options, kernel(n, m), work=[(n, m), (n,)], follows=False)
