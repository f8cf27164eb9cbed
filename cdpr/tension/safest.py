"""The point of { x : low <= c + N x <= high } that is as far from all limits as can be, and how far that is."""

from __future__ import annotations

import math

from cdpr.model.jit import apart, kernel, small
from cdpr.model.robot import Array
from cdpr.tension import active_set
from cdpr.tension.active_set import extreme
from cdpr.tension.status import UNSUPPORTED
from cdpr.tension.verdict import VERTEX_TOLERANCE


@small
@kernel
def work_rows(m: int) -> int:
    """Rows of work space that `safest_point` needs."""
    return 2 * m + 7 + active_set.work_rows(m + 1)


@apart
@kernel
def safest_point(ball: bool, N: Array, r: int, box: Array, x: Array, work: Array) -> float:
    """Write x (r,) and return the largest s with low + s d <= c + N x <= high - s d; of several x that of least norm.

    d_i is 1, so that s is the smallest distance of a tension from its limits; with `ball` it is the length of row i of
    N, so that s is the radius of the largest ball within the limits, and x its centre (Chebyshev). Locked cables
    (low = high) do not count. s is negative where no x lies within the limits; inf where nothing can be changed or,
    with infinite limits, s can be as large as one likes; NaN where the linear program was not solved. N is (m, >= r),
    rows that are round-off made zero, as by `reduce`; the rows of `box` (3, >= m) are c, low and high; `work` has
    `work_rows(m)` rows and 2 m + 1 columns.

    A linear program in (x, s), whose start at x = 0 is made feasible by s alone.
    """
    m = N.shape[0]
    c, low, high = box[0], box[1], box[2]
    rows, level = work[: 2 * m], work[2 * m : 2 * m + 3]  # the linear program's N and box
    g, y, point, active = work[2 * m + 3], work[2 * m + 4], work[2 * m + 5], work[2 * m + 6]
    rest = work[2 * m + 7 :]
    for j in range(r):
        x[j] = g[j] = 0.0
    count, stuck, scale = 0, 0.0, 0.0
    for i in range(m):
        scale = max(scale, abs(c[i]))
        square = 0.0
        for j in range(r):
            square += N[i, j] * N[i, j]
        size = math.sqrt(square)
        d = 1.0
        if ball:
            d = size
            if size == 0.0:  # x does not change it: it only has to be right
                stuck = max(stuck, low[i] - c[i], c[i] - high[i])
                continue
        if low[i] == high[i]:
            continue
        for upper in range(2):
            for j in range(r):
                rows[count, j] = N[i, j]
            rows[count, r] = d if upper else -d
            level[0, count] = c[i]
            level[1, count] = -math.inf if upper else low[i]
            level[2, count] = high[i] if upper else math.inf
            count += 1
    if stuck > VERTEX_TOLERANCE * scale:
        return -stuck
    if count == 0:
        return math.inf
    g[r] = -1.0
    steps = extreme(g, rows, r + 1, level, y, point[:count], active[:count], rest)
    for j in range(r):
        x[j] = y[j]
    if steps < 0:
        return math.inf if steps == -UNSUPPORTED else math.nan
    return float(y[r])
