"""What an exit is: where a cable leaves the frame on its way from the winch to the platform.

A cable runs from its winch to the exit, leaves it at the exit point E and goes straight on to its anchor on the
platform, P. Where E depends on P, the cable's direction is that from P to E, and its length |E - P| plus what lies on
the exit. For any exit on which a taut cable lies without friction this length changes by -u . dP, u being the unit
vector from P to E: what the exit point's own motion adds to |E - P| is what it takes from the rest. So the rates, the
wrench matrix and the forces follow from E alone.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from cdpr.fields import Kind


class Exit(Kind):
    """An exit, as a robot file describes it.

    Attributes:
        header: of its kernel, a struct of templates over the number type T, included by `cdpr/parts.hpp`:
            `leave(anchor, numbers, tip)`, the exit point, m, world, for a cable to the tip; `lead(anchor, numbers,
            tip)`, the same with the length of cable that lies on the exit, m; `carry(...)`, the velocity of the exit
            point, m/s, when the tip moves. Empty for a point, which has no need of any.
    """

    header: ClassVar[str] = ""

    @abstractmethod
    def numbers(self) -> Sequence[float]:
        """Return the numbers that its kernel takes, in its order."""

    def turned(self, R: NDArray[np.float64]) -> Self:
        """Return it as the rotation matrix R (3, 3) turns it about its anchor."""
        return self

    def obstacle(self, frame: Sequence[float], tip: Sequence[float]) -> str:
        """Return why no cable leads from the anchor at `frame` to the one at `tip`, m, world; "" where one does."""
        return ""

    @abstractmethod
    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return points (k, 3), m, of a line that shows the exit at `frame` while its cable leaves at `leaving`."""

    def swivel(self) -> Sequence[float] | None:
        """Return the unit vector of the line through the anchor across which the exit point jumps; None without one."""
        return None
