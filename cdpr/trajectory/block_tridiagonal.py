"""Symmetric positive definite systems of 2 x 2 blocks, each beside its neighbours: compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.bind import bind


def solve_block_tridiagonal(diagonal: ArrayLike, upper: ArrayLike, right: ArrayLike) -> Array:
    """Solve a symmetric positive definite system; time and memory grow with K.

    Args:
        diagonal: (K, 2, 2), blocks on the diagonal.
        upper: (K - 1, 2, 2), blocks right of it.
        right: (K, 2).

    Returns:
        The solution (K, 2); not finite where the system is singular.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> solve_block_tridiagonal([[[4.0, 0.0], [0.0, 2.0]]], np.empty((0, 2, 2)), [[2.0, 2.0]])
        array([[0.5, 1. ]])
    """
    given = {"diagonal": diagonal, "upper": upper, "right": right}
    arrays = {name: np.ascontiguousarray(value, dtype=np.float64) for name, value in given.items()}
    solution = np.empty(arrays["right"].shape)
    bind("block_tridiagonal", **arrays, solution=solution)()
    return solution
