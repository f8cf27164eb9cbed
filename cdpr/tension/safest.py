"""The point of { x : low <= c + N x <= high } that is as far from all limits as can be, and how far that is."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension import active_set
from cdpr.tension.active_set import DEPENDENCE_TOLERANCE, VERTEX_TOLERANCE, extreme


def work_size(m: int, r: int) -> int:
    """Floats that `safest_point` needs as work space."""
    return 2 * m * (r + 1) + 10 * m + 2 * (r + 1) + active_set.work_size(2 * m, r + 1)


@kernel
def safest_point(ball: bool, N: Array, r: int, c: Array, low: Array, high: Array, x: Array, work: Array) -> float:
    """Write x (r,) and return the largest s with low + s d <= c + N x <= high - s d; of several x that of least norm.

    d_i is 1, so that s is the smallest distance of a tension from its limits; with `ball` it is the length of row i of
    N, so that s is the radius of the largest ball within the limits, and x its centre (Chebyshev). Locked cables
    (low = high) do not count. s is negative where no x lies within the limits, inf where nothing can be changed, NaN
    where the linear program was not solved. `work` holds `work_size(m, r)` floats.

    A linear program in (x, s), whose start at x = 0 is made feasible by s alone.
    """
    m = c.shape[0]
    width = r + 1
    o = 2 * m * width
    level = work[o : o + 2 * m]
    lowest = work[o + 2 * m : o + 4 * m]
    highest = work[o + 4 * m : o + 6 * m]
    point = work[o + 6 * m : o + 8 * m]
    active = work[o + 8 * m : o + 10 * m]
    o += 10 * m
    g = work[o : o + width]
    y = work[o + width : o + 2 * width]
    rest = work[o + 2 * width :]
    rows = work[: 2 * m * width].reshape(2 * m, width)
    count = 0
    for i in range(m):
        square = 0.0
        for j in range(r):
            square += N[i, j] * N[i, j]
        size = math.sqrt(square)
        d = 1.0
        if ball:
            d = size
            if size <= DEPENDENCE_TOLERANCE:  # x cannot change it: it only has to be right
                excess = max(low[i] - c[i], c[i] - high[i])
                if excess > VERTEX_TOLERANCE * max(abs(c[i]), abs(low[i])):
                    return -float(excess)
                continue
        if low[i] == high[i]:
            continue
        for upper in range(2):
            for j in range(r):
                rows[count, j] = N[i, j]
            rows[count, r] = d if upper else -d
            level[count] = c[i]
            lowest[count] = -math.inf if upper else low[i]
            highest[count] = high[i] if upper else math.inf
            count += 1
    for j in range(r):
        x[j] = g[j] = 0.0
    if count == 0:
        return math.inf
    g[r] = -1.0
    steps = extreme(
        g, rows[:count], width, level[:count], lowest[:count], highest[:count], y, point[:count], active[:count], rest
    )
    if steps < 0:
        return math.nan
    for j in range(r):
        x[j] = y[j]
    return float(y[r])
