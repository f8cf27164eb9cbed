"""The motion of a platform on which a tool moves as is desired.

Where the platform keeps its attitude, its origin moves as the tool does, an offset away. Where it turns, the origin's
way is no polynomial: it is met in position, velocity and acceleration at so many places that it is missed by less than
`MISSED` between them; attitudes stay exactly as they were.
"""

from __future__ import annotations

from math import comb

import numpy as np

from cdpr.errors import CdprError
from cdpr.model import rotations
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.trajectory.knots import quintic
from cdpr.trajectory.trajectory import COLUMNS, Trajectory

MISSED = 1e-9  # m, below what any engine or comparison here tells apart
MOST = 4096  # pieces of a segment; they miss by the sixth power of their length, so none has needed a tenth of them
_LOOKS = (0.25, 0.5, 0.75)  # shares of a piece at which it is looked at
# Coefficient k of a polynomial of w u + s is w^k times the sum over j of _SHIFT[k, j] s^(j - k) c_j.
_SHIFT = np.array([[comb(j, k) for j in range(6)] for k in range(6)], dtype=np.float64)


def of_tool(motion: Trajectory, tool: Array) -> Trajectory:
    """Return the motion of the platform's origin by which a tool moves as `motion` says.

    Args:
        motion: of the tool, and the platform's attitude.
        tool: (3,) where it is on the platform, m, platform axes.

    Raises CdprError where the platform turns too wildly to follow.
    """
    arm = checked(tool, (3,), "tool")
    found = []
    for segment in motion.segments:
        if segment[20:38].reshape(3, 6)[:, 1:].any():
            found += _pieces(segment, arm)
        else:
            moved = segment.copy()
            moved[2:20:6] -= rotations.matrix(Trajectory(segment).sample(segment[0])[3:7]) @ arm
            found.append(moved)
    return Trajectory(np.array(found))


def _pieces(segment: Array, arm: Array) -> list[Array]:
    """The origin's way in a segment in which the platform turns."""
    motion, count = Trajectory(segment), 1
    while count <= MOST:
        edges = np.linspace(0.0, 1.0, count + 1)
        ends = np.array([_origin(motion, arm, edge) for edge in edges])
        h = np.full((count, 1), segment[1] / count)
        found = np.empty((count, COLUMNS))
        found[:, 0], found[:, 1], found[:, 38:] = segment[0] + segment[1] * edges[:-1], h[:, 0], segment[38:]
        x, v, a = ends[:, 0], ends[:, 1], ends[:, 2]
        found[:, 2:20] = quintic(h, x[:-1], x[1:] - x[:-1], v[:-1], v[1:], a[:-1], a[1:])
        found[:, 20:38] = [_part(segment[20:38], low, 1.0 / count) for low in edges[:-1]]
        if all(
            _missed(piece, motion, arm, low, 1.0 / count) <= MISSED
            for piece, low in zip(found, edges[:-1], strict=True)
        ):
            return list(found)
        count *= 2
    raise CdprError(f"trajectory: from {segment[0]:g} s on the platform turns too wildly for a tool to be followed")


def _part(coefficients: Array, low: float, share: float) -> Array:
    """Coefficients (18,) of three quintics, as they are from a share `low` on, of a `share` of their duration."""
    k = np.arange(6)
    shift = _SHIFT * low ** np.maximum(k[None] - k[:, None], 0) * (share**k)[:, None]
    return np.asarray(coefficients.reshape(3, 6) @ shift.T).ravel()


def _missed(piece: Array, motion: Trajectory, arm: Array, low: float, share: float) -> float:
    """How far the piece is off the way, m."""
    where, k = piece[2:20].reshape(3, 6), np.arange(6)
    return max(float(np.abs(where @ look**k - _origin(motion, arm, low + share * look)[0]).max()) for look in _LOOKS)


def _origin(motion: Trajectory, arm: Array, share: float) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration (3,) of the platform's origin at a share of a segment; world axes."""
    at = motion.sample(motion.start + (motion.end - motion.start) * share)
    spin, reach = at[10:13], rotations.matrix(at[3:7]) @ arm
    turned = np.cross(spin, reach)
    return at[:3] - reach, at[7:10] - turned, at[13:16] - np.cross(at[16:], reach) - np.cross(spin, turned)
