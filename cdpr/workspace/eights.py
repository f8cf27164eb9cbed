"""Many poses, eight at a time, of robots with two cables more than directions; compiled.

Each is answered to the bit as it is alone; those that are not, for their W lacks rank, are asked for alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cdpr.cables.lines import ANCHORS
from cdpr.mechanics import geometry
from cdpr.model import kernels
from cdpr.model.jit import DISABLED, kernel, threaded_kernel
from cdpr.model.kinds import CUBE, NOTHING, TABLE, Group
from cdpr.model.lanes import WIDTH, aligned, bits, side_by_side
from cdpr.model.robot import Array
from cdpr.tension import null_space
from cdpr.workspace.assess import (
    ASKED,
    CLOSURE,
    FOUND,
    PAYLOAD,
    REGULAR,
    SPACE,
    Asked,
    Found,
    Space,
    needed,
    one,
    weigh,
    widest,
)
from cdpr.workspace.redundancy_two import TWO, Pair, closure_of_two, margin_of_two, pair_shapes


class Eight(NamedTuple):
    """Work space, its last axis that of eight."""

    state: Array  # (13, 8), at rest
    six: Array  # (6, 8)
    wrench: Array  # (n, 8)
    value: Array  # (2, 8)
    off: Array  # (m, 8)
    best: Array  # (n, 8)
    W6: Array  # (6, m, 8)
    W: Array  # (n, m, 8)
    limits: Array  # (2, m, 8)
    box: Array  # (3, m, 8)
    N: Array  # (m, m, 8): `reduce` writes as many columns as W leaves, which may be more than two
    required: Array  # (k, n, 8)
    work: Array  # (n + 5, m, 8)
    gram: Array  # as in `Pair`, all of them
    Y: Array
    G: Array
    Z: Array


EIGHT = Group((TABLE,) * 6 + (CUBE,) * 11, Eight)


def eights_serve(asked: Asked) -> bool:
    """Whether poses can be asked for eight at a time."""
    n, m = len(asked.rows), len(asked.lines)
    from_points = asked.lines.shape[1] == ANCHORS
    free = bool((asked.limits[0] < asked.limits[1]).all())
    return not DISABLED and from_points and free and m - n == TWO and n > 3 and asked.mode != PAYLOAD


def eight_for(asked: Asked) -> Eight:
    """Return work space for one thread."""
    n, m, k = len(asked.rows), len(asked.lines), len(asked.vectors)
    gram, Y, G, Z, off, best = (aligned((*shape, WIDTH)) for shape in pair_shapes(n, m, k))
    state, limits = aligned((13, WIDTH)), aligned((2, m, WIDTH))
    state[:], limits[:] = 0.0, asked.limits[:, :, None]
    six, wrench, value = aligned((6, WIDTH)), aligned((n, WIDTH)), aligned((2, WIDTH))
    W6, W, box, N = aligned((6, m, WIDTH)), aligned((n, m, WIDTH)), aligned((3, m, WIDTH)), aligned((m, m, WIDTH))
    required, work = aligned((k, n, WIDTH)), aligned((null_space.work_rows(n), max(n, m), WIDTH))
    return Eight(state, six, wrench, value, off, best, W6, W, limits, box, N, required, work, gram, Y, G, Z)


@kernel
def together(asked: Asked, eight: Eight) -> int:
    """Write values and directions of the eight poses in `eight.state`; return the bits of those that are answered."""
    n, m = asked.rows.shape[0], asked.lines.shape[0]
    state, six, wrench = side_by_side(eight.state), side_by_side(eight.six), side_by_side(eight.wrench)
    W6, W, box, N = side_by_side(eight.W6), side_by_side(eight.W), side_by_side(eight.box), side_by_side(eight.N)
    limits, work, value = side_by_side(eight.limits), side_by_side(eight.work), side_by_side(eight.value)
    required = side_by_side(eight.required)
    still = (0.0, 0.0, 0.0)
    geometry.point_columns(asked.lines, state, W6)
    q = kernels.quaternion(state, 3)
    kernels.inverse_dynamics(asked.inertial, asked.gravity, q, still, still, still, six)
    weigh(asked.weights, asked.rows, W6, six, W, wrench)
    needed(asked, q, six, required)
    if null_space.reduce(W, wrench, limits[0], limits[1], box, N, work) != TWO:
        return 0
    sound = null_space.common(n, m, limits[0], limits[1], work)
    if asked.mode == CLOSURE:
        value[0] = closure_of_two(N)
        value[1] = 1.0 + 0.0 * value[0]
        return bits(sound)
    pair = Pair(
        side_by_side(eight.gram),
        side_by_side(eight.Y),
        side_by_side(eight.G),
        side_by_side(eight.Z),
        side_by_side(eight.off),
        side_by_side(eight.best),
    )
    return bits(sound & margin_of_two(asked.form, W, asked.limits, box, N, required, pair, value))


@threaded_kernel(NOTHING(ASKED, FOUND, SPACE, EIGHT))
def assess_eights(asked: Asked, found: Found, space: Space, eight: Eight) -> None:
    """Write what is found of all poses, as `assess` does."""
    n, first, count = asked.rows.shape[0], 0, found.poses.shape[0]
    while first + WIDTH <= count:
        for lane in range(WIDTH):
            for i in range(7):
                eight.state[i, lane] = found.poses[first + lane, i]
        answered = together(asked, eight)
        for lane in range(WIDTH):
            k = first + lane
            if answered >> lane & 1:
                found.status[k] = REGULAR
                found.value[k], found.scale[k] = eight.value[0, lane], eight.value[1, lane]
                for j in range(n):
                    found.direction[k, j] = math.nan if asked.mode == CLOSURE else eight.best[j, lane]
                found.limit[k] = widest(found.direction[k])
            else:
                one(asked, found, k, space)
        first += WIDTH
    for k in range(first, count):
        one(asked, found, k, space)
