"""Compiled enclosures of position-dependent numbers in a box by first-order Taylor models, on numpy arrays.

A model (c, x, y, z, r) means: anywhere in a box with half sides h, at the offset d from the centre, the number is c + x
d_x / h_x + y d_y / h_y + z d_z / h_z, within r (enclosure.hpp).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real, reals
from cdpr.native.bind import bind


class Models(NamedTuple):
    """Results of `arithmetic`.

    Attributes:
        sum: (k, 5), models of first + second.
        product: (k, 5), models of first times second.
        multiple: (k, 5), models of factor times first.
        largest: (k,), upper bounds of |first|.
    """

    sum: Array
    product: Array
    multiple: Array
    largest: Array


def arithmetic(first: ArrayLike, second: ArrayLike, factor: ArrayLike) -> Models:
    """Return models of sums, products and multiples.

    Args:
        first: (k, 5), models.
        second: (k, 5), models.
        factor: (k,), numbers.

    Returns:
        The models.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> arithmetic([[1, 0, 0, 0, 0]], [[2, 0, 0, 0, 0]], [3.0]).largest.round(9)
        array([1.])
    """
    one, other, number = real(first, "first"), real(second, "second"), real(factor, "factor")
    shape = len(one), 5
    found = Models(np.empty(shape), np.empty(shape), np.empty(shape), np.empty(len(one)))
    bind("model_arithmetic", first=one, second=other, factor=number, **found._asdict())()
    return found


def inverse_distance(vector: ArrayLike, half: ArrayLike, error: ArrayLike) -> Array:
    """Return models of 1 / |v - d| in boxes.

    Args:
        vector: (k, 3) m, v.
        half: (k, 3) m, half sides of the boxes.
        error: (k,) m, largest error of each entry of v.

    Returns:
        (k, 5) models, 1/m; r is infinite if the distance may be 0.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> float(inverse_distance([[2.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]], [0.0])[0, 0])
        0.5
    """
    given = reals(vector=vector, half=half, error=error)
    model = np.empty((len(given["vector"]), 5))
    bind("inverse_distances", **given, model=model)()
    return model
