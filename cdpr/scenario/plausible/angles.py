"""Angles beyond a full turn, which were probably written in degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.scenario.plausible.setup import Finding, Setup

WHOLE_TURN = 2.0 * math.pi * (1.0 + 1e-6)  # rad; tolerates a full turn with six digits
WHOLE_TURN_IN_DEGREES = 360.0

# Sections with options of plugins.
FOREIGN = ("backend_options", "controller", "solver", "estimator")

# Keys of angles, by their last components. Motions of more than one turn count turns separately.
RADIANS = (("orientation", "rpy"), ("euler", "angles"), ("phase",))
DEGREES = (("orientation", "rpy_deg"), ("euler", "angles_deg"), ("phase_deg",))
LAST = {ending[-1] for ending in (*RADIANS, *DEGREES)}


def whole_turns(setup: Setup) -> Iterator[Finding]:
    """Yield attitudes and phases beyond a full turn."""
    node: Any = setup.data
    for part in setup.root if setup.run is None else ():
        node = node[part]
    for path, angles in _angles(node, setup.root if setup.run is None else ()):
        if text := in_degrees(angles) if _ends(path, RADIANS) else _more_than_whole(angles):
            yield path, text


def in_degrees(angles: Any) -> str:
    """Return a warning if an angle, rad, exceeds a full turn, else ""."""
    angle = _largest(angles)
    if abs(angle) <= WHOLE_TURN:
        return ""
    meant = f"{exact(angle)} degrees are {math.radians(angle):.6g} rad"
    return f"{exact(angle)} rad is more than a whole turn; angles are in radians: {meant}"


def _more_than_whole(angles: Any) -> str:
    angle = _largest(angles)
    if abs(angle) <= WHOLE_TURN_IN_DEGREES:
        return ""
    same = math.remainder(angle, WHOLE_TURN_IN_DEGREES)
    return f"{exact(angle)} degrees is more than a whole turn: the attitude is that of {same:.6g} degrees"


def _largest(angles: Any) -> float:
    given = angles if isinstance(angles, list) else [angles]
    sound = [angle for angle in given if isinstance(angle, (int, float)) and math.isfinite(angle)]
    return float(max(sound, key=abs, default=0.0))


def _angles(node: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    """Yield the angles in plain data, with their paths."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        if not path and key in FOREIGN:
            continue
        here = (*path, key)
        if key in LAST and (_ends(here, RADIANS) or _ends(here, DEGREES)):
            yield here, item
        elif isinstance(item, (dict, list)):
            yield from _angles(item, here)


def _ends(path: Path, endings: tuple[tuple[str, ...], ...]) -> bool:
    return any(path[-len(ending) :] == ending for ending in endings)
