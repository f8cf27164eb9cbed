"""Admissible tensions in null-space form, { x : low <= c + N x <= high }, with numpy arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real, reals
from cdpr.native.compute import compute


def general_solution(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Array] | None:
    """Return c and N such that all t with W t = wrench are c + N x.

    Args:
        matrix: (n, m), rows of the wrench matrix W, moments about the platform's origin, world axes.
        wrench: (n,), N and N m, required wrench of the cables.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable with equal limits is locked at that tension.

    Returns:
        c (m,), N: the solution of least norm, except for locked cables. N (m, r): orthonormal columns, orthogonal to c;
            rows of cables that x does not change are zero. None if no tensions produce the wrench, or an input is
            invalid.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> general_solution([[1.0, 0.0]], [2.0], [0.0, 0.0], [9.0, 9.0])
        (array([2., 0.]), array([[0.],
               [1.]]))
    """
    arrays = reals(matrix=matrix, wrench=wrench, tension_min=tension_min, tension_max=tension_max)
    m = arrays["matrix"].shape[-1:]
    shapes = {"center": m, "basis": (*m, *m), "redundancy": (1,)}
    status, (center, basis, redundancy) = compute("null_space_form", arrays, shapes)
    if status:
        return None
    return center, np.ascontiguousarray(basis[:, : int(redundancy[0])])


def admissible_corners(basis: ArrayLike, center: ArrayLike, low: ArrayLike, high: ArrayLike) -> Array:
    """Return the corners of the admissible x for one or two redundant cables.

    Mikelsons, Bruckmann, Schramm and Hiller (2008); Gouttefarde, Lamaury, Reichert and Bruckmann (2015).

    Args:
        basis: (m, r), N, with r = 1 or 2.
        center: (m,) N, a solution c.
        low: (m,) N, finite.
        high: (m,) N, finite.

    Returns:
        Corners (k, r), N: the ends of an interval, or a polygon anticlockwise. k is 0 if no tensions are admissible, 1
            for a point, 2 for a segment.

    Raises:
        ValueError: if the shapes do not match, or r is neither 1 nor 2.

    Example:
        >>> admissible_corners([[0.6], [0.8]], [0.0, 0.0], [0.0, 0.0], [6.0, 4.0])
        array([[0.],
               [5.]])
    """
    N = real(basis, "basis")
    if N.ndim != 2 or N.shape[1] not in (1, 2):
        raise ValueError(f"basis: expected shape (m, 1) or (m, 2), got {N.shape}.")
    shapes = {"corners": (2 * len(N) + 4, N.shape[1]), "count": (1,)}
    operation = "admissible_interval" if N.shape[1] == 1 else "admissible_polygon"
    box = np.stack(list(reals(center=center, low=low, high=high).values()))
    _, (corners, count) = compute(operation, {"basis": N, "box": box}, shapes)
    return corners[: int(count[0])]


def farthest_from_limits(
    basis: ArrayLike, center: ArrayLike, low: ArrayLike, high: ArrayLike, *, ball: bool = False
) -> tuple[float, Array]:
    """Return the x with the largest distance from all limits; of several, the one of least norm.

    Args:
        basis: (m, r), N; rows that are round-off must be zero.
        center: (m,) N, a solution c.
        low: (m,) N.
        high: (m,) N. Cables with equal limits are ignored.
        ball: measure distances in x, for the largest ball within the limits (Chebyshev), instead of tensions.

    Returns:
        The distance, N: negative if no x is within the limits, infinite if unbounded, NaN if the method failed. x (r,),
            N.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> farthest_from_limits([[0.6], [0.8]], [0.0, 0.0], [0.0, 0.0], [6.0, 8.0])
        (3.0, array([5.]))
    """
    N = real(basis, "basis")
    box = np.stack(list(reals(center=center, low=low, high=high).values()))
    shapes = {"x": N.shape[1:], "distance": (1,)}
    _, (x, distance) = compute("safest_point", {"basis": N, "box": box}, shapes, ball=int(ball))
    return float(distance[0]), x
