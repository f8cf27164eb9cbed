"""A path of many pieces, and how each is to be passed."""

from __future__ import annotations

from dataclasses import dataclass

from numpy import bool_
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.trajectory.curves import Curves


@dataclass(frozen=True, eq=False)
class Course:
    """N pieces of a path, one after the other.

    Attributes:
        pieces: where they go.
        speed: largest on each piece, m/s, (N,).
        tolerance: how far the corner at the end of each may be missed, m, (N,); 0 for not at all.
        stop: whether the motion rests at the end of each, (N,).
        pause: how long, s, (N,); 0 where it does not stop.
    """

    pieces: Curves
    speed: Array
    tolerance: Array
    stop: NDArray[bool_]
    pause: Array
