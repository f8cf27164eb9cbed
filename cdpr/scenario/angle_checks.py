"""Angles that are allowed and seldom meant: an attitude of more than a whole turn was written in degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from cdpr.scenario.checks import Checks
from cdpr.scenario.problems import Path, exact

WHOLE_TURN = 2.0 * math.pi * (1.0 + 1e-6)  # rad; a whole turn may be typed with six digits

# Their options are the plugins' own.
FOREIGN = ("backend_options", "controller", "solver")


def in_degrees(angles: Any) -> str:
    """Return what is to be said of angles, in rad, of which one exceeds a whole turn; nothing where none does."""
    given = angles if isinstance(angles, list) else [angles]
    sound = [angle for angle in given if isinstance(angle, (int, float)) and math.isfinite(angle)]
    angle = max(sound, key=abs, default=0.0)
    if abs(angle) <= WHOLE_TURN:
        return ""
    meant = f"{exact(angle)} degrees are {math.radians(angle):.6g} rad"
    return f"{exact(angle)} rad is more than a whole turn; angles are in radians: {meant}"


class AngleChecks(Checks):
    """Warns of attitudes and phases beyond a whole turn; motions that turn more than once count their turns apart."""

    def run(self) -> None:
        """Look at all that is no plugin's."""
        for path, angles in _angles(self.document.data, ()):
            if text := in_degrees(angles):
                self.warn(path, text)


def _angles(node: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    """Yield the angles in plain data, with their paths."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        here = (*path, key)
        if here[0] in FOREIGN:
            continue
        if here[-2:] == ("orientation", "rpy") or here[-2:] == ("euler", "angles") or here[-1] == "phase":
            yield here, item
        else:
            yield from _angles(item, here)
