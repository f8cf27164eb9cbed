"""Small positive definite systems, solved in place inside kernels."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

# A direction whose remaining curvature is below this share counts as unobservable: round-off of the factorisation.
SINGULAR = 1e-13


@kernel
def factorise(A: Array, damping: float) -> bool:
    """Replace the lower half of A by the Cholesky factor of A + damping diag(A); False where it is singular."""
    for k in range(A.shape[0]):
        for j in range(k + 1):
            s = A[k, j]
            if j == k:
                s *= 1.0 + damping
            least = SINGULAR * s
            for i in range(j):
                s -= A[k, i] * A[j, i]
            if j < k:
                A[k, j] = s / A[j, j]
            elif s > least:
                A[k, k] = math.sqrt(s)
            else:
                return False
    return True


@kernel
def factorise_each(A: Array) -> bool:
    """Do what `factorise` does without damping, of lanes, too: say which are not singular; others become rubbish."""
    sound: bool = A[0, 0] == A[0, 0]
    for k in range(A.shape[0]):
        for j in range(k + 1):
            s = A[k, j]
            least = SINGULAR * s
            for i in range(j):
                s -= A[k, i] * A[j, i]
            if j < k:
                A[k, j] = s / A[j, j]
            else:
                sound = sound & (s > least)
                A[k, k] = math.sqrt(s)
    return sound


@kernel
def solve(L: Array, b: Array, x: Array) -> None:
    """Write x with L L^T x = b, each (n,)."""
    n = b.shape[0]
    for k in range(n):
        s = b[k]
        for j in range(k):
            s -= L[k, j] * x[j]
        x[k] = s / L[k, k]
    for k in range(n - 1, -1, -1):
        s = x[k]
        for j in range(k + 1, n):
            s -= L[j, k] * x[j]
        x[k] = s / L[k, k]
