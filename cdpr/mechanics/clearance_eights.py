"""Clearances of many poses, eight at a time, where all cables leave from points: each to the bit as alone; compiled."""

from __future__ import annotations

import numpy as np

from cdpr.mechanics.clearance import BODIES, NEAREST, Bodies, Nearest, among_cables, among_solids, nearest
from cdpr.model.jit import threaded_kernel
from cdpr.model.kernels import quaternion, vector
from cdpr.model.kinds import CUBE, NOTHING, TABLE
from cdpr.model.lanes import WIDTH, aligned, side_by_side
from cdpr.model.robot import Array


def memory(m: int) -> tuple[Array, Array, Array, Array]:
    """Return work space for m cables: eight poses, where their cables end, what is nearest, and ends of one pose."""
    return aligned((7, WIDTH)), aligned((m, 6, WIDTH)), aligned((2, WIDTH)), np.empty((m, 6))


@threaded_kernel(NOTHING(BODIES, NEAREST, TABLE, CUBE, TABLE, TABLE))
def look_eights(bodies: Bodies, found: Nearest, poses: Array, ends: Array, value: Array, own: Array) -> None:
    """Write what is found of all poses, as `look` does."""
    m, first, count = bodies.lines.shape[0], 0, found.poses.shape[0]
    pose, end, told = side_by_side(poses), side_by_side(ends), side_by_side(value)
    solids = bodies.platform.shape[0] + bodies.obstacles.shape[0] > 0
    while first + WIDTH <= count:
        for lane in range(WIDTH):
            for i in range(7):
                poses[i, lane] = found.poses[first + lane, i]
        told[0], told[1] = among_cables(bodies, vector(pose, 0), quaternion(pose, 3), end)
        for lane in range(WIDTH):
            k = first + lane
            found.clearance[k], found.which[k] = value[0, lane], int(value[1, lane])
            if solids:
                for i in range(m):
                    for j in range(6):
                        own[i, j] = ends[i, j, lane]
                least, which = among_solids(bodies, found.poses[k], own, value[0, lane], int(value[1, lane]))
                found.clearance[k], found.which[k] = least, which
        first += WIDTH
    for k in range(first, count):
        found.clearance[k], found.which[k] = nearest(bodies, found.poses[k], own)
