"""Desired motions: piecewise quintic, at rest before the first segment and after the last.

`through` and `interpolate` return smooth curves through knots; `arch` and `circle` are standard paths. `stop_to_stop`
respects limits of velocity, acceleration and jerk, as `cdpr.gcode.following.follow` does along lines and arcs.
`redirected` changes a motion's target, and `of_tool` moves a tool of the platform. All use one table of segments and
one kernel.

Example:
    >>> import cdpr
    >>> still = cdpr.trajectory.hold([0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0])
    >>> type(still).__name__
    'Trajectory'
"""

from typing import TYPE_CHECKING

from cdpr.base.lazy import lazily
from cdpr.trajectory.trajectory import Stopping, Trajectory, hold

if TYPE_CHECKING:
    from cdpr.trajectory.jerk_limited import Limits, Stop, stop_to_stop
    from cdpr.trajectory.knots import Knot, interpolate, through
    from cdpr.trajectory.paths import arch, circle
    from cdpr.trajectory.redirect import redirected
    from cdpr.trajectory.tool import of_tool
else:  # a motion uses few of them
    __getattr__ = lazily(
        __name__,
        {
            "Knot": "cdpr.trajectory.knots",
            "Limits": "cdpr.trajectory.jerk_limited",
            "Stop": "cdpr.trajectory.jerk_limited",
            "arch": "cdpr.trajectory.paths",
            "circle": "cdpr.trajectory.paths",
            "interpolate": "cdpr.trajectory.knots",
            "of_tool": "cdpr.trajectory.tool",
            "redirected": "cdpr.trajectory.redirect",
            "stop_to_stop": "cdpr.trajectory.jerk_limited",
            "through": "cdpr.trajectory.knots",
        },
    )

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
    "of_tool",
    "redirected",
    "stop_to_stop",
    "through",
]
