"""The facets of what cables can exert: the normals that bound {W t : low <= t <= high}, one after the other; compiled.

A normal c of a facet is orthogonal to n - 1 columns of W (n, m) that it is spanned by, so p = W^T c is a vector of W's
row space that is zero in these: an elementary vector, with at most r + 1 entries, r = m - n. Of both descriptions the
shorter one is used: n - 1 columns and the c orthogonal to them (hyperplane shifting: Bouchard, Gosselin and Moore, ASME
J. Mech. Robot. 2, 2010), or r + 1 cables and the p orthogonal to their rows of the null space N (its Gale dual). The
farthest that the cables reach along c is h = sum max(p_i low_i, p_i high_i).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

# A normal that is shorter than this, of unit vectors, is one of columns, or of rows of N, that depend on one another:
# what is spanned by them is no facet, or that of others.
DEPENDENT = 1e-11

# Forms of sets of required wrenches, as `cdpr.workspace.required.FORMS`.
ZONOTOPE, ELLIPSOID, VERTICES = range(3)


@kernel
def next_subset(index: NDArray[np.int64], count: int, m: int) -> bool:
    """Write the next `count` of m numbers, ascending, after those in `index`; whether there is one."""
    k = count - 1
    while k >= 0 and index[k] == m - count + k:
        k -= 1
    if k < 0:
        return False
    index[k] += 1
    for j in range(k + 1, count):
        index[j] = index[j - 1] + 1
    return True


@kernel
def orthogonal(A: Array, k: int, x: Array) -> bool:
    """Write a unit vector x (k + 1,) with A[:k] x = 0, A (>= k, >= k + 1) of rows about as long as 1, and destroyed.

    False where there are several. Of up to two rows it is a cross product, else elimination with complete pivoting.
    """
    if k == 0:
        x[0] = 1.0
        return True
    if k == 1:
        x[0], x[1] = -A[0, 1], A[0, 0]
    elif k == 2:
        x[0] = A[0, 1] * A[1, 2] - A[0, 2] * A[1, 1]
        x[1] = A[0, 2] * A[1, 0] - A[0, 0] * A[1, 2]
        x[2] = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    else:
        return _eliminated(A, k, x)
    size = 0.0
    for i in range(k + 1):
        size += x[i] * x[i]
    size = math.sqrt(size)
    if not size > DEPENDENT:
        return False
    for i in range(k + 1):
        x[i] /= size
    return True


@kernel
def _eliminated(A: Array, k: int, x: Array) -> bool:
    """Do that of any number of rows; A[k] holds which unknown stands in which column."""
    for j in range(k + 1):
        A[k, j] = j
    for step in range(k):
        row, column, largest = step, step, 0.0
        for i in range(step, k):
            for j in range(step, k + 1):
                if abs(A[i, j]) > largest:
                    row, column, largest = i, j, abs(A[i, j])
        if not largest > DEPENDENT:
            return False
        if row != step:
            for j in range(k + 1):
                A[step, j], A[row, j] = A[row, j], A[step, j]
        if column != step:
            for i in range(k + 1):
                A[i, step], A[i, column] = A[i, column], A[i, step]
        for i in range(step + 1, k):
            factor = A[i, step] / A[step, step]
            for j in range(step, k + 1):
                A[i, j] -= factor * A[step, j]
    last = int(A[k, k])
    x[last] = 1.0
    size = 1.0
    for i in range(k - 1, -1, -1):
        s = -A[i, k]
        for j in range(i + 1, k):
            s -= A[i, j] * x[int(A[k, j])]
        value = s / A[i, i]
        x[int(A[k, i])] = value
        size += value * value
    size = math.sqrt(size)
    for i in range(k + 1):
        x[i] /= size
    return True
