"""Geometry, statics and dynamics of robots. See `cdpr.model` for the conventions.

Example:
    >>> import cdpr
    >>> robot = cdpr.load_robot("caroca")
    >>> cdpr.mechanics.kinematics.lengths(robot, [*robot.home, *[0.0] * 6]).shape
    (8,)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cdpr.mechanics import forward_kinematics as forward_kinematics
    from cdpr.mechanics import kinematics as kinematics
    from cdpr.mechanics import properties as properties
else:  # loaded on first use
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__)
