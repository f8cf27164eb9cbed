"""G-code: its interpreter, and the path of a program within limits of velocity, acceleration and jerk.

Lines and arcs form a course; `follow` plans a motion along it, with rounded corners where a tolerance allows them.
"""

from typing import TYPE_CHECKING

from cdpr.base.lazy import lazily

if TYPE_CHECKING:
    from cdpr.gcode.course import Course
    from cdpr.gcode.curves import Curves, arcs, lines, together
    from cdpr.gcode.following import follow
else:
    __getattr__ = lazily(
        __name__,
        {
            "Course": "cdpr.gcode.course",
            "Curves": "cdpr.gcode.curves",
            "arcs": "cdpr.gcode.curves",
            "follow": "cdpr.gcode.following",
            "lines": "cdpr.gcode.curves",
            "together": "cdpr.gcode.curves",
        },
    )

__all__ = ["Course", "Curves", "arcs", "follow", "lines", "together"]
