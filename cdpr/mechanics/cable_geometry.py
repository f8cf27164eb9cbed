"""Wrench matrix, lengths and rates of the cables, computed by compiled operations on numpy arrays.

See `cdpr.model` for the conventions. The equations are those of Pott, Cable-Driven Parallel Robots (2018), chapter 3:
l_i = A_i - p - R B_i, u_i = l_i / |l_i|, and column i of the wrench matrix is [u_i; R B_i x u_i]. `lines` is the table
of `cdpr.cables.tables.line_table`, (m, 6) or wider.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.compute import compute


def cable_geometry(lines: Array, state: ArrayLike) -> tuple[Array, Array, Array]:
    """Compute the wrench matrix and the lengths and rates of the cables.

    Args:
        lines: (m, w) table of `line_table`.
        state: (13,) position [m], quaternion w, x, y, z, velocity [m/s] and angular velocity [rad/s], in world axes.

    Returns:
        Wrench matrix (6, m) with moments about the platform's origin, in world axes; lengths (m,) [m]; rates (m,)
            [m/s].
        Values of a cable are NaN if it has no length or if no cable path over its pulley exists.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> from cdpr.cables.tables import line_table
        >>> robot = cdpr.load_robot("caroca")
        >>> matrix, length, rate = cable_geometry(line_table(robot), [*robot.home, *[0.0] * 6])
        >>> matrix.shape, length.shape, rate.shape
        ((6, 8), (8,), (8,))
    """
    m = _count(lines)
    shapes = {"matrix": (6, *m), "length": m, "rate": m}
    _, (matrix, length, rate) = compute("geometry", {"lines": lines, "state": state}, shapes)
    return matrix, length, rate


def wrench_matrix_rate(lines: Array, state: ArrayLike) -> Array:
    """Compute the time derivative of the wrench matrix.

    Args:
        lines: (m, w) table of `line_table`.
        state: (13,) state as in `cable_geometry`.

    Returns:
        (6, m) rates of the force rows [1/s] and of the moment rows [m/s].

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> from cdpr.cables.tables import line_table
        >>> robot = cdpr.load_robot("caroca")
        >>> bool((wrench_matrix_rate(line_table(robot), [*robot.home, *[0.0] * 6]) == 0.0).all())
        True
    """
    _, (rate,) = compute("matrix_rate", {"lines": lines, "state": state}, {"rate": (6, *_count(lines))})
    return rate


def cable_wrench(lines: Array, pose: ArrayLike, tension: ArrayLike) -> Array:
    """Compute the wrench of the cables on the platform.

    Args:
        lines: (m, w) table of `line_table`.
        pose: (7,) position [m] and quaternion w, x, y, z.
        tension: (m,) tensions [N].

    Returns:
        (6,) force [N] and moment about the platform's origin [N m], in world axes.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> from cdpr.cables.tables import line_table
        >>> robot = cdpr.load_robot("caroca")
        >>> cable_wrench(line_table(robot), robot.home, robot.tension_min).shape
        (6,)
    """
    given = {"lines": lines, "pose": pose, "tension": tension}
    _, (wrench,) = compute("cable_wrench", given, {"wrench": (6,)})
    return wrench


def _count(lines: ArrayLike) -> tuple[int, ...]:
    """Return the number of cables in a shape; an empty one if the table is a single number."""
    table: Array = lines if type(lines) is np.ndarray else real(lines, "lines")
    return table.shape[:1]
