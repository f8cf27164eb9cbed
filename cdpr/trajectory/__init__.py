"""The desired motion: quintic segments, at rest before the first and after the last.

`through` and `interpolate` make smooth curves through knots, `arch` and `circle` are paths of a given form, and
`stop_to_stop` is as fast as limits on velocity, acceleration and jerk allow; `redirected` leaves a motion for a pose.
All become one table, for one kernel.
"""

from typing import TYPE_CHECKING

from cdpr.lazy import lazily
from cdpr.trajectory.jerk_limited import Limits, Stop, stop_to_stop
from cdpr.trajectory.knots import Knot, interpolate, through
from cdpr.trajectory.paths import arch, circle
from cdpr.trajectory.redirect import redirected
from cdpr.trajectory.trajectory import Stopping, Trajectory, hold

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = [
    "Knot",
    "Limits",
    "Stop",
    "Stopping",
    "Trajectory",
    "arch",
    "circle",
    "hold",
    "interpolate",
    "redirected",
    "stop_to_stop",
    "through",
]
