"""The desired motion: quintic segments, at rest before the first and after the last.

`through` and `interpolate` make smooth curves through knots, `arch` and `circle` are paths of a given form, and
`stop_to_stop` and `follow`, which goes along lines and arcs, keep limits on velocity, acceleration and jerk;
`redirected` leaves a motion for a pose, `of_tool` lets a tool of the platform move. All become one table, for
one kernel.
"""

from typing import TYPE_CHECKING

from cdpr.lazy import lazily
from cdpr.trajectory.course import Course, follow
from cdpr.trajectory.curves import Curves, arcs, lines, together
from cdpr.trajectory.jerk_limited import Limits, Stop, stop_to_stop
from cdpr.trajectory.knots import Knot, interpolate, through
from cdpr.trajectory.paths import arch, circle
from cdpr.trajectory.redirect import redirected
from cdpr.trajectory.tool import of_tool
from cdpr.trajectory.trajectory import Stopping, Trajectory, hold

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = [
    "Course",
    "Curves",
    "Knot",
    "Limits",
    "Stop",
    "Stopping",
    "Trajectory",
    "arch",
    "arcs",
    "circle",
    "follow",
    "hold",
    "interpolate",
    "lines",
    "of_tool",
    "redirected",
    "stop_to_stop",
    "through",
    "together",
]
