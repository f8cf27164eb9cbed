"""The compiled loop over many distributions."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.mechanics import geometry
from cdpr.model import kernels
from cdpr.model.jit import threaded_kernel
from cdpr.model.kinds import CUBE, INDICES, NOTHING, ROW, TABLE, WHOLE, Block, Function, Group, Plain
from cdpr.model.robot import Array
from cdpr.tension.checks import accept, select
from cdpr.tension.policy import fall_back
from cdpr.tension.status import BAD_INPUT, OK


class Way(NamedTuple):
    """How each row is answered, beside the solver's kernel."""

    parameters: Array  # of the solver, as its kernel takes them
    size: tuple[int, int]  # shape of the kernel's work space
    action: int  # what `fall_back` does where the answer fails the checks
    spare: tuple[int, int]  # shape of the work space of `fall_back`


class Common(NamedTuple):
    """What all rows have in common: n degrees of freedom, m cables."""

    lines: Array  # as `cdpr.cables.lines` says
    rows: NDArray[np.int64]  # (n,), of a wrench, as `select` takes them
    inertial: Array  # (13,), as `Robot.inertial`
    gravity: Array  # (3,), m/s^2
    weights: Array  # (n,), as `judge` takes them


class Rows(NamedTuple):
    """K problems and their answers."""

    limits: Array  # (K, 2, m), N, or (1, 2, m) for all
    poses: Array  # (K, 7), quaternions of any length
    wrenches: Array  # (K, 6), N and N m; or (0, 6): what holds the platform still against gravity
    tension: Array  # (K, m), N, written
    report: Array  # (K, 4), written, as `judge` says


SIZE = Group((WHOLE, WHOLE))
DONE = Block(Plain("uint8"), 1)
KERNEL = Function(WHOLE(TABLE, *[ROW] * 5, TABLE))
WAY = Group((ROW, SIZE, WHOLE, SIZE), Way)
COMMON = Group((TABLE, INDICES, ROW, ROW, ROW), Common)
ROWS = Group((CUBE, *[TABLE] * 4), Rows)


# The solver's kernel comes as a pointer, so that this is compiled once for all of them and kept on disk.
@threaded_kernel(NOTHING(KERNEL, WAY, COMMON, ROWS, DONE))
def distribute_rows(kernel: Callable[..., int], way: Way, common: Common, given: Rows, done: NDArray[np.uint8]) -> None:
    """Fill tension and report of all rows but those that are `done` (K,) already: where that is not 0.

    A row with an entry that is not finite, or limits that contradict each other, is BAD_INPUT, its tensions are NaN.
    """
    lines, rows, weights, poses, wrenches = common.lines, common.rows, common.weights, given.poses, given.wrenches
    limits, tension, report, parameters = given.limits, given.tension, given.report, way.parameters
    m, n = lines.shape[0], rows.shape[0]
    W6, wrench6, W, wrench = np.empty((6, m)), np.empty(6), np.empty((n, m)), np.empty(n)
    state, lengths, rates, answer = np.zeros(13), np.empty(m), np.empty(m), np.empty(m)
    work, spare_work = np.empty(way.size), np.empty(way.spare)
    still = (0.0, 0.0, 0.0)
    for k in range(poses.shape[0]):
        if done[k]:
            continue
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
            kernels.inverse_dynamics(
                common.inertial, common.gravity, kernels.quaternion(state, 3), still, still, still, wrench6
            )
        select(rows, W6, wrench6, W, wrench)
        status = kernel(W, wrench, own[0], own[1], answer, parameters, work) if sound else BAD_INPUT
        answered = status == OK
        if answered:
            status = accept(W, wrench, weights, own, answer, tension[k], report[k])
        if status != OK:
            doing = way.action if answered else 0
            if not sound or not fall_back(
                doing, status, W, wrench, weights, own, answer, tension[k], report[k], spare_work
            ):
                report[k, 0] = BAD_INPUT
                report[k, 1:] = np.nan
                tension[k] = np.nan
