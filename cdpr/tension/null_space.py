"""Tension distribution in null-space form: W t = wrench, low <= t <= high as low <= c + N x <= high.

Of lanes (`cdpr.model.lanes`), those are answered as if alone for which `common` holds afterwards; others stray.
"""

from __future__ import annotations

import math

from cdpr.model.jit import apart, kernel, small
from cdpr.model.lanes import choose, of_lanes, some, whole
from cdpr.model.rank import RANK_TOLERANCE
from cdpr.model.robot import Array
from cdpr.tension.status import BAD_INPUT, INFEASIBLE, NOT_FOUND

# A dependent row is consistent if the wrench agrees with the other rows to this share of the largest load.
CONSISTENCY_TOLERANCE = 1e-9

# A row of N, whose columns are of unit length, that is shorter than this is round-off: the wrench alone determines the
# tension of that cable, and whatever divided by such a row would divide by noise.
ROUNDING = 1e-11

# Coordinates beyond this cannot be added up without becoming infinite: there are no such tensions.
TOO_LARGE = 1e300


@small
@kernel
def form_rows(m: int) -> int:
    """Rows of a work space that the form takes: m for N, then 3 for the box."""
    return m + 3


@small
@kernel
def work_rows(n: int) -> int:
    """Rows of work space that `reduce` needs."""
    return n + 5


@apart
@kernel
def reduce(W: Array, wrench: Array, t_min: Array, t_max: Array, box: Array, N: Array, work: Array) -> int:
    """Write all solutions of W t = wrench, W (n, m), as t = c + N[:, :r] x; return r, the redundancy.

    `box` (3, >= m) receives c and the limits. c is the solution of least norm, but for cables whose limits are equal:
    they are locked, or cut, where that is 0. Their tension is given and the others balance what is left. The columns of
    N (m, >= r) are orthonormal and orthogonal to c, so that |t|^2 = |c|^2 + |x|^2. A row of N is zero, exactly, if and
    only if x does not change that cable: it is locked, or the wrench alone determines its tension.

    Returns -INFEASIBLE where W is rank-deficient and the wrench outside its range, -NOT_FOUND where the tensions are
    larger than numbers can be, -BAD_INPUT where an entry is not
    finite, a lower limit above the upper one or the work space too small. `work` has at least `work_rows(n)` rows and
    max(n, m) columns: rows of a table, for numba slices a table at no cost, whereas reshaping a line takes some 40 ns.
    W may have further columns.
    """
    r = reduce_to_point(W, wrench, t_min, t_max, box, N, work)
    if r >= 0:
        complete(wrench.shape[0], r, box, N, work)
    return r


@kernel
def reduce_to_point(W: Array, wrench: Array, t_min: Array, t_max: Array, box: Array, N: Array, work: Array) -> int:
    """Do what `reduce` does, but for N, which `complete` writes where it is needed."""
    m = N.shape[0]
    rank, free = factorise(m, W, wrench, t_min, t_max, box, work)
    if rank < 0:
        return rank
    _solve(wrench.shape[0], free, rank, box, work)
    return free - rank


@apart
@kernel
def complete(n: int, r: int, box: Array, N: Array, work: Array) -> None:
    """Write N from what `reduce_to_point`, which has returned r, has left in `box` and `work`."""
    m, free = N.shape[0], 0
    for i in range(m):
        if some(box[1, i] < box[2, i]):
            free += 1
    _expand(n, free, free - r, free - r, free, N, work)
    for i in range(m):
        longest = 0.0
        for column in range(r):
            longest = max(longest, abs(N[i, column]))
        if some(longest <= ROUNDING):
            for column in range(r):
                N[i, column] = choose(longest <= ROUNDING, 0.0, N[i, column])


@apart
@kernel
def reduce_to_rows(W: Array, wrench: Array, t_min: Array, t_max: Array, box: Array, B: Array, work: Array) -> int:
    """Write W t = wrench, W (n, m), as B[:, :k]^T t = B[:, :k]^T c with orthonormal columns; return k, the rank.

    B (m, >= k) spans the rows of W, as N of `reduce` their null space; the rest is as there.
    """
    m = B.shape[0]
    rank, free = factorise(m, W, wrench, t_min, t_max, box, work)
    if rank < 0:
        return rank
    _expand(wrench.shape[0], free, rank, 0, rank, B, work)
    _solve(wrench.shape[0], free, rank, box, work)
    return rank


@kernel
def _expand(n: int, free: int, rank: int, first: int, end: int, basis: Array, work: Array) -> None:
    """Write Q e_first to Q e_(end - 1), as columns, from what `factorise` has left in `work`."""
    cable, y = work[n + 1], work[n + 4]
    if free < basis.shape[0]:
        for i in range(basis.shape[0]):
            for column in range(end - first):
                basis[i, column] = 0.0
    for unit in range(first, end):
        for i in range(free):
            y[i] = 0.0
        y[unit] = 1.0
        _turn(n, free, rank, work)
        for i in range(free):
            basis[whole(cable[i]), unit - first] = y[i]


@kernel
def _solve(n: int, free: int, rank: int, box: Array, work: Array) -> None:
    """Write c into `box`, likewise."""
    rhs, cable, y = work[n], work[n + 1], work[n + 4]
    for i in range(free):
        y[i] = rhs[i] if i < rank else 0.0
    _turn(n, free, rank, work)
    for i in range(free):
        box[0, whole(cable[i])] = y[i]


@kernel
def _turn(n: int, free: int, rank: int, work: Array) -> None:
    """Multiply y, in `work`, by Q."""
    scale, y = work[n + 2], work[n + 4]
    for k in range(rank - 1, -1, -1):
        v = work[k]
        s = 0.0
        for i in range(k, free):
            s += v[i] * y[i]
        s *= scale[k]
        for i in range(k, free):
            y[i] -= s * v[i]


@apart
@kernel
def factorise(m: int, W: Array, wrench: Array, t_min: Array, t_max: Array, box: Array, work: Array) -> tuple[int, int]:
    """Write the limits and locked tensions into `box`, factors into `work`; return the rank and how many are free.

    For `reduce` and `reduce_to_rows`, which say what the arguments are; instead of a rank, minus a status.
    """
    n = wrench.shape[0]
    if not (W.shape[0] >= n and W.shape[1] >= m and work.shape[0] >= n + 5 and work.shape[1] >= max(n, m)):
        return -BAD_INPUT, 0  # made for another robot
    if t_min.shape[0] < m or t_max.shape[0] < m:
        return -BAD_INPUT, 0
    rhs, cable = work[n], work[n + 1]  # the wrench that is left, and the number of each free cable
    free, sound, load = 0, 0.0, 0.0
    for i in range(m):
        low, high = t_min[i], t_max[i]
        if not some(low <= high):  # NaN, too
            return -BAD_INPUT, 0
        box[0, i] = low  # what a locked cable keeps
        box[1, i] = low
        box[2, i] = high
        if some(low < high):
            cable[free] = i
            free += 1
    for j in range(n):
        s = wrench[j]
        load = max(load, abs(s))
        for i in range(m):
            sound += 0.0 * W[j, i]
            if free < m and not some(t_min[i] < t_max[i]):
                s -= W[j, i] * t_min[i]
                load = max(load, abs(W[j, i] * t_min[i]))
        rhs[j] = s
        sound += 0.0 * s
        if free == m:
            for i in range(m):
                work[j, i] = W[j, i]
        else:
            for k in range(free):
                work[j, k] = W[j, whole(cable[k])]
    if not some(sound == 0.0):
        return -BAD_INPUT, free
    return _triangulate(n, free, CONSISTENCY_TOLERANCE * load, work), free


@kernel
def _triangulate(n: int, free: int, allowed: float, work: Array) -> int:
    """Householder factorisation of V^T with column pivoting (Golub and Van Loan, algorithm 5.4.1), V = work[:n, :free].

    V holds the rows of W; below the diagonal of its transpose come to stand the Householder vectors.
    """
    V = work[:n]
    rhs, scale, diagonal, square = work[n], work[n + 2], work[n + 3], work[n + 4]
    for j in range(n):
        s = 0.0
        for i in range(free):
            s += V[j, i] * V[j, i]
        square[j] = s
    rank = 0
    largest = 0.0
    for k in range(min(n, free)):
        norm = math.sqrt(_bring_longest(V, rhs, square, k, n, free))
        if k == 0:
            largest = norm
        if not some(norm > RANK_TOLERANCE * largest):
            break
        v = V[k]
        alpha = v[k]
        beta = choose(alpha >= 0.0, -norm, norm)
        # H = 1 - scale v v^T with v = column - beta e_k turns the column into beta e_k.
        v[k] = alpha - beta
        factor = 1.0 / (norm * (norm + abs(alpha)))
        scale[k] = factor
        diagonal[k] = beta
        for j in range(k + 1, n):
            row = V[j]
            s = 0.0
            for i in range(k, free):
                s += v[i] * row[i]
            s *= factor
            row[k] -= s * v[k]
            left = 0.0
            for i in range(k + 1, free):
                value = row[i] - s * v[i]
                row[i] = value
                left += value * value
            square[j] = left
        rank += 1
    # R^T y = rhs, row by row; dependent rows must agree.
    for j in range(n):
        s = rhs[j]
        for k in range(min(j, rank)):
            s -= V[j, k] * rhs[k]
        if j < rank:
            rhs[j] = s / diagonal[j]
            if not some(abs(rhs[j]) < TOO_LARGE):
                return -NOT_FOUND
        elif not some(abs(s) <= allowed):
            return -INFEASIBLE
    return rank


def _bring_longest(V: Array, rhs: Array, square: Array, k: int, n: int, free: int) -> float:
    """Exchange row k of V[:n, :free], and of `rhs`, for the longest from there on; return the square of its length."""
    pivot = k
    for j in range(k + 1, n):
        if square[j] > square[pivot]:
            pivot = j
    if pivot != k:
        rhs[k], rhs[pivot] = rhs[pivot], rhs[k]
        for i in range(free):
            V[k, i], V[pivot, i] = V[pivot, i], V[k, i]
    return float(square[pivot])


@of_lanes(_bring_longest)
def _bring_longest_of_each(V: Array, rhs: Array, square: Array, k: int, n: int, free: int) -> float:
    """Do that of lanes, each with a row of its own."""
    longest: float = square[k]
    pivot = 0.0 * longest + k
    for j in range(k + 1, n):
        longer = square[j] > longest
        longest, pivot = choose(longer, square[j], longest), choose(longer, j, pivot)
    for j in range(k + 1, n):
        here = pivot == j
        if some(here):
            rhs[k], rhs[j] = choose(here, rhs[j], rhs[k]), choose(here, rhs[k], rhs[j])
            for i in range(free):
                V[k, i], V[j, i] = choose(here, V[j, i], V[k, i]), choose(here, V[k, i], V[j, i])
    return longest


@kernel
def common(n: int, m: int, t_min: Array, t_max: Array, work: Array) -> bool:
    """Whether lanes went through `reduce` as each would have alone: of full rank, with all cables free, finite.

    `work` as `reduce` has left it, with rank n and m free cables.
    """
    rhs, diagonal = work[n], work[n + 3]
    largest = abs(diagonal[0])
    found: bool = largest < math.inf
    for k in range(n):
        norm = abs(diagonal[k])
        found = found & (norm > RANK_TOLERANCE * largest) & (abs(rhs[k]) < TOO_LARGE)
    for i in range(m):
        found = found & (t_min[i] < t_max[i])
    return found
