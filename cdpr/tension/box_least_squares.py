"""The tensions within the limits that come nearest to a wrench: what remains when no distribution is admissible."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.active_set import nearest

# Weight of |t|^2 against the squared residual, relative to the largest diagonal entry of the normal matrix. It makes
# the answer unique and close to the minimum-norm distribution. The price: in directions in which the cables have less
# than about 1e-4 of their largest effect (squared: this weight), the residual stays larger than it need be.
REGULARISATION = 1e-8


def work_size(n: int, m: int) -> int:
    """Floats that `box_least_squares` needs as work space."""
    return 4 * m * m + 10 * m + 1


@kernel
def box_least_squares(
    W: Array, wrench: Array, weights: Array, low: Array, high: Array, tension: Array, work: Array
) -> int:
    """Write the tensions (m,) that minimise |D (W t - wrench)|^2 + e |t|^2 within low <= t <= high.

    D = diag(weights) (n,): with 1 for forces and 1 / characteristic length for moments the residual is in newtons.
    Any n, m and rank. Returns the steps of the active set, negative if it gave up. `work` holds 4 m^2 + 10 m + 1.

    With H = W^T D^2 W + e = L L^T and y = L^T t this is the nearest point of a polytope to the unconstrained optimum.
    """
    n, m = W.shape
    L = work[: m * m].reshape(m, m)
    N = work[m * m : 2 * m * m].reshape(m, m)
    o = 2 * m * m
    c = work[o : o + m]
    x = work[o + m : o + 2 * m]
    y = work[o + 2 * m : o + 3 * m]
    active = work[o + 3 * m : o + 4 * m]
    rest = work[o + 4 * m :]
    largest = 0.0
    for i in range(m):
        s = 0.0
        for k in range(n):
            s += weights[k] ** 2 * W[k, i] * wrench[k]
        y[i] = s
        for j in range(i + 1):
            s = 0.0
            for k in range(n):
                s += weights[k] ** 2 * W[k, i] * W[k, j]
            L[i, j] = s
        largest = max(largest, L[i, i])
    epsilon = REGULARISATION * (largest if largest > 0.0 else 1.0)
    for i in range(m):  # Cholesky, row by row
        for j in range(i + 1):
            s = L[i, j]
            if i == j:
                s += epsilon
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = math.sqrt(max(s, epsilon * 1e-8)) if i == j else s / L[j, j]
    for i in range(m):  # y = L^-1 W^T D^2 wrench
        s = y[i]
        for k in range(i):
            s -= L[i, k] * y[k]
        y[i] = s / L[i, i]
    for column in range(m):  # N = L^-T, upper triangular
        for i in range(m - 1, -1, -1):
            s = 1.0 if i == column else 0.0
            for k in range(i + 1, m):
                s -= L[k, i] * N[k, column]
            N[i, column] = s / L[i, i]
    for i in range(m):
        s = 0.0
        for j in range(i, m):
            s += N[i, j] * y[j]
        c[i] = s
    return nearest(N, m, c, low, high, x, tension, active, rest)
