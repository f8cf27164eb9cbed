"""Environment of a platform, for backends that simulate more than cables and gravity."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.model.shapes import Obstacle


@dataclass(frozen=True)
class Environment:
    """Bodies and media around a platform that affect its motion; each field has its default where there are none.

    A backend declares the fields that it supports in the property `surroundings`, such as ["obstacles"]. A scenario
    with others is rejected.

    Attributes:
        obstacles: fixed bodies that the platform touches with its shape, `robot.platform.shape`.

    Example:
        >>> import numpy as np
        >>> from cdpr.model import Box
        >>> from cdpr.model.shapes import Obstacle
        >>> from cdpr.plugins import Environment
        >>> upright = np.array([1.0, 0.0, 0.0, 0.0])
        >>> table = Obstacle("table", Box((2.0, 1.0, 0.1)), np.array([0.0, 0.0, 0.5]), upright)
        >>> [each.name for each in Environment(obstacles=(table,)).obstacles]
        ['table']
    """

    obstacles: tuple[Obstacle, ...] = ()

    def __post_init__(self) -> None:
        given: object = self.obstacles
        items = given if isinstance(given, list | tuple) else [given]
        if wrong := [each for each in items if not isinstance(each, Obstacle)]:
            raise CdprError(f"Environment(obstacles=): expected a tuple of Obstacle, got {shown(wrong[0])}")
        vars(self).update(obstacles=tuple(items))
