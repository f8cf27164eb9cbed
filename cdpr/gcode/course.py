"""Path of many pieces with speeds, tolerances and stops."""

from __future__ import annotations

from dataclasses import dataclass

from numpy import bool_
from numpy.typing import NDArray

from cdpr.gcode.curves import Curves
from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Course:
    """N contiguous pieces of a path.

    Attributes:
        pieces: geometry.
        speed: largest speed on each piece, m/s, (N,).
        tolerance: allowed distance from the corner at the end of each piece, m, (N,); 0 for exact corners.
        stop: True if the motion stops at the end of the piece, (N,).
        pause: duration of the stop, s, (N,); 0 without stop.
    """

    pieces: Curves
    speed: Array
    tolerance: Array
    stop: NDArray[bool_]
    pause: Array
