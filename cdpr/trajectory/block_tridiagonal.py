"""Compiled solution of symmetric positive definite block tridiagonal systems with 2 x 2 blocks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import reals
from cdpr.native.bind import bind


def solve_block_tridiagonal(diagonal: ArrayLike, upper: ArrayLike, right: ArrayLike) -> Array:
    """Solve a symmetric positive definite system; time and memory are linear in K.

    Args:
        diagonal: (K, 2, 2), blocks on the diagonal.
        upper: (K - 1, 2, 2), blocks right of it.
        right: (K, 2).

    Returns:
        The solution (K, 2); not finite if the system is singular.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> solve_block_tridiagonal([[[4.0, 0.0], [0.0, 2.0]]], np.empty((0, 2, 2)), [[2.0, 2.0]])
        array([[0.5, 1. ]])
    """
    arrays = reals(diagonal=diagonal, upper=upper, right=right)
    solution = np.empty(arrays["right"].shape)
    bind("block_tridiagonal", **arrays, solution=solution)()
    return solution
