"""Interface of exits: the point at which a cable leaves the frame on its way from the winch to the platform.

A cable runs from its winch to the exit, leaves it at the exit point E and runs straight to its anchor on the platform,
P. If E depends on P, the cable's direction is from P to E, and its length is |E - P| plus the part on the exit. For any
exit on which a taut cable lies without friction, this length changes by -u . dP, with u the unit vector from P to E:
the motion of the exit point adds to |E - P| what it takes from the rest. So the rates, the wrench matrix and the forces
follow from E alone.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from cdpr.base.fields import Kind


class Exit(Kind):
    """Exit, as described in a robot file.

    Attributes:
        header: header of its kernel, a struct of templates over the number type T, included by `cdpr/cables/parts.hpp`:
            `leave(anchor, numbers, tip)` returns the exit point, m, world, for a cable to the tip; `lead(anchor,
            numbers, tip)` also returns the length of cable on the exit, m; `carry(...)` returns the velocity of the
            exit point, m/s, when the tip moves. "" for a point, which needs none. An exit with friction also has
            `friction(numbers, wrap, speed)`: the tension towards the winch per tension towards the platform.
    """

    header: ClassVar[str] = ""

    @abstractmethod
    def numbers(self) -> Sequence[float]:
        """Return the numbers of its kernel in order."""

    @property
    def rubs(self) -> bool:
        """True if friction changes the tension on the exit."""
        return False

    def damping(self, frame: Sequence[float], tip: Sequence[float]) -> float:
        """Return the damping by friction at rest, per tension, s/m, of a cable from the anchor at `frame` to a tip."""
        return 0.0

    def turned(self, R: NDArray[np.float64]) -> Self:
        """Return the exit rotated about its anchor by the rotation matrix R (3, 3)."""
        return self

    def obstacle(self, frame: Sequence[float], tip: Sequence[float]) -> str:
        """Return why no cable leads from the anchor at `frame` to the one at `tip`, m, world; "" if one does."""
        return ""

    @abstractmethod
    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return points (k, 3), m, of a line that shows the exit at `frame` with its cable leaving at `leaving`."""

    def swivel(self) -> Sequence[float] | None:
        """Return the unit vector of the line through the anchor across which the exit point jumps; None without one."""
        return None
