"""Small positive definite systems, solved by a compiled Cholesky factorisation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.native.arrays import real
from cdpr.native.bind import bind

Array = NDArray[np.float64]


def solve_positive_definite(matrix: ArrayLike, right: ArrayLike, damping: float = 0.0) -> Array:
    """Solve (A + damping diag(A)) x = b.

    Args:
        matrix: (n, n), A, symmetric; only its lower half is read.
        right: (n,), b.
        damping: relative increase of the diagonal, as in the method of Levenberg and Marquardt.

    Returns:
        (n,), x; NaN if the matrix is singular or not positive definite: a pivot is below 1e-13 of its diagonal
        entry (Golub and Van Loan, Matrix Computations, section 4.2).

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> solve_positive_definite([[4.0, 0.0], [0.0, 2.0]], [2.0, 2.0])
        array([0.5, 1. ])
    """
    A = real(matrix, "matrix")
    b = real(right, "right")
    solution = np.empty(b.shape)
    bind("positive_definite", matrix=A, right=b, solution=solution, damping=damping)()
    return solution
