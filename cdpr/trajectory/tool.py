"""Motion of the platform for a desired motion of a tool.

If the platform keeps its attitude, its origin moves parallel to the tool. If it turns, the origin's path is no
polynomial: it is interpolated in position, velocity and acceleration with an error below `MISSED`. Attitudes are exact.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.model import rotations
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.trajectory.knots import quintic
from cdpr.trajectory.trajectory import COLUMNS, Trajectory, sample_segments

Indices = NDArray[np.int64]

MISSED = 1e-9  # m, below the resolution of engines and comparisons
MOST = 4096  # pieces of a segment; the error falls with the sixth power of their length, so a tenth has always sufficed
CHUNK = 16384  # segments per batch, to limit memory
_LOOKS = (0.25, 0.5, 0.75)  # shares of a piece at which the error is checked
# Coefficient k of a polynomial of w u + s is w^k times the sum over j of _SHIFT[k, j] s^(j - k) c_j.
_SHIFT = np.array([[comb(j, k) for j in range(6)] for k in range(6)], dtype=np.float64)


def of_tool(motion: Trajectory, tool: Array) -> Trajectory:
    """Return the motion of the platform's origin for which a tool moves along `motion`.

    Args:
        motion: motion of the tool with the platform's attitude.
        tool: (3,), position on the platform, m, platform axes.

    Raises:
        CdprError: if the platform turns too fast for the interpolation.
    """
    arm, segments = checked(tool, (3,), "tool"), motion.segments
    return Trajectory(
        np.concatenate([_moved(segments[row : row + CHUNK], arm) for row in range(0, len(segments), CHUNK)])
    )


def _moved(segments: Array, arm: Array) -> Array:
    """Return the segments of the origin for segments (N, 42) of the tool, N or more."""
    turning = segments[:, 20:38].reshape(-1, 3, 6)[:, :, 1:].any(axis=(1, 2))
    still, left, count = np.flatnonzero(~turning), np.flatnonzero(turning), 1
    moved = segments[still]
    moved[:, 2:20:6] -= _reach(_desired(segments, still, np.zeros(len(still))), arm)
    found, owner = [moved], [still]
    while len(left):
        if count > MOST:
            begin = segments[left[0], 0]
            raise CdprError(f"trajectory: from {begin:g} s on the platform turns too wildly for a tool to be followed")
        pieces, near = _pieces(segments, left, arm, count)
        found.append(pieces[near].reshape(-1, COLUMNS))
        owner.append(np.repeat(left[near], count))
        left, count = left[~near], 2 * count
    return np.concatenate(found)[np.argsort(np.concatenate(owner), kind="stable")]


def _pieces(segments: Array, which: Indices, arm: Array, count: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return the origin's motion in segments (N,) with rotation, in `count` pieces each, (N, count, 42).

    The second result is True for segments with a sufficiently small error, (N,).
    """
    edges, many = np.linspace(0.0, 1.0, count + 1), len(which)
    ends = _origins(segments, np.repeat(which, count + 1), arm, np.tile(edges, many)).reshape(many, count + 1, 3, 3)
    given = segments[which]
    found = np.empty((many, count, COLUMNS))
    found[:, :, 0] = given[:, :1] + given[:, 1:2] * edges[:-1]
    found[:, :, 1], found[:, :, 38:] = given[:, 1:2] / count, given[:, None, 38:]
    first, last = ends[:, :-1].reshape(-1, 3, 3), ends[:, 1:].reshape(-1, 3, 3)
    h = found[:, :, 1].reshape(-1, 1)
    x, step = first[:, 0], last[:, 0] - first[:, 0]
    way = quintic(h, x, step, first[:, 1], last[:, 1], first[:, 2], last[:, 2])
    found[:, :, 2:20] = way.reshape(many, count, 18)
    for number, low in enumerate(edges[:-1]):
        found[:, number, 20:38] = _part(given[:, 20:38], low, 1.0 / count)
    near = np.ones(many * count, dtype=bool)
    for look in _LOOKS:
        there = _origins(segments, np.repeat(which, count), arm, np.tile(edges[:-1] + look / count, many))[:, 0]
        near &= np.abs(way.reshape(-1, 3, 6) @ look ** np.arange(6) - there).max(axis=1) <= MISSED
    return found, np.asarray(near.reshape(many, count).all(axis=1))


def _part(coefficients: Array, low: float, share: float) -> Array:
    """Return the coefficients (N, 18) of three quintics restricted to a `share` of their duration from `low` on."""
    k = np.arange(6)
    shift = _SHIFT * low ** np.maximum(k[None] - k[:, None], 0) * (share**k)[:, None]
    return np.asarray(coefficients.reshape(-1, 3, 6) @ shift.T).reshape(-1, 18)


def _desired(segments: Array, which: Indices, shares: Array) -> Array:
    """Return samples (K, 19) of segments (K,) at shares (K,) of them."""
    return sample_segments(segments, which, segments[which, 0] + segments[which, 1] * shares)


def _reach(desired: Array, arm: Array) -> Array:
    """Return the vectors from the origin to a point (3,) of the platform at samples (K, 19), (K, 3), m, world axes."""
    return rotations.rotate(desired[:, 3:7], arm)


def _origins(segments: Array, which: Indices, arm: Array, shares: Array) -> Array:
    """Return position, velocity and acceleration (K, 3, 3) of the platform's origin, world axes.

    The samples are at shares (K,) of segments (K,).
    """
    at = _desired(segments, which, shares)
    spin, reach = at[:, 10:13], _reach(at, arm)
    turned = np.cross(spin, reach)
    bent = np.cross(at[:, 16:], reach) + np.cross(spin, turned)
    return np.stack([at[:, :3] - reach, at[:, 7:10] - turned, at[:, 13:16] - bent], axis=1)
