"""The compiled loop over many distributions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import types
from numpy.typing import NDArray

from cdpr.mechanics import geometry
from cdpr.model import kernels
from cdpr.model.jit import threaded_kernel
from cdpr.model.robot import Array
from cdpr.tension.checks import accept, select
from cdpr.tension.policy import fall_back
from cdpr.tension.status import BAD_INPUT, OK

VECTOR, MATRIX, CUBE = (types.Array(types.float64, dimensions, "C") for dimensions in (1, 2, 3))
INDICES = types.Array(types.int64, 1, "C")
SIZE = types.UniTuple(types.int64, 2)
KERNEL = types.FunctionType(types.int64(MATRIX, *[VECTOR] * 5, MATRIX))


# The solver's kernel comes as a pointer, so that this is compiled once for all of them and kept on disk.
@threaded_kernel(
    types.void(KERNEL, VECTOR, SIZE, SIZE, types.int64, MATRIX, INDICES, *[VECTOR] * 3, CUBE, *[MATRIX] * 4)
)
def distribute_rows(
    kernel: Callable[..., int],
    parameters: Array,
    size: tuple[int, int],
    spare: tuple[int, int],
    action: int,
    lines: Array,
    rows: NDArray[np.int64],
    inertial: Array,
    gravity: Array,
    weights: Array,
    limits: Array,
    poses: Array,
    wrenches: Array,
    tension: Array,
    report: Array,
) -> None:
    """Fill tension (K, m) and report (K, 4) for poses (K, 7), whose quaternions are normalised.

    `kernel`, `parameters` and the shape of its work space, `size`, are a compiled solver's; `action` and the shape of
    its work space, `spare`, as `fall_back` says, `rows` as `select`, `weights` and `report` as `judge`. `limits` are
    (K, 2, m), or (1, 2, m) for all. Without `wrenches` (K, 6) the platform is held still against `gravity`. A row with
    an entry that is not finite, or limits that contradict each other, is BAD_INPUT, its tensions are NaN.
    """
    m, n = lines.shape[0], rows.shape[0]
    W6, wrench6, W, wrench = np.empty((6, m)), np.empty(6), np.empty((n, m)), np.empty(n)
    state, lengths, rates, answer = np.zeros(13), np.empty(m), np.empty(m), np.empty(m)
    work, spare_work = np.empty(size), np.empty(spare)
    still = (0.0, 0.0, 0.0)
    for k in range(poses.shape[0]):
        state[:7] = poses[k]
        length = math.sqrt(state[3] ** 2 + state[4] ** 2 + state[5] ** 2 + state[6] ** 2)
        for i in range(3, 7):
            state[i] /= length
        answer[:] = np.nan
        own = limits[k if limits.shape[0] > 1 else 0]
        sound = True
        for i in range(m):
            sound = sound and own[0, i] <= own[1, i]
        geometry.cable_geometry(lines, state, W6, lengths, rates)
        if wrenches.shape[0] > 0:
            wrench6[:] = wrenches[k]
        else:
            kernels.inverse_dynamics(inertial, gravity, kernels.quaternion(state, 3), still, still, still, wrench6)
        select(rows, W6, wrench6, W, wrench)
        status = kernel(W, wrench, own[0], own[1], answer, parameters, work) if sound else BAD_INPUT
        answered = status == OK
        if answered:
            status = accept(W, wrench, weights, own, answer, tension[k], report[k])
        if status != OK:
            doing = action if answered else 0
            if not sound or not fall_back(
                doing, status, W, wrench, weights, own, answer, tension[k], report[k], spare_work
            ):
                report[k, 0] = BAD_INPUT
                report[k, 1:] = np.nan
                tension[k] = np.nan
