"""Steps of a G-code program, in SI units, independent of its start."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from cdpr.gcode.tables import PLANES
from cdpr.model.frozen import Frozen

Triple = tuple[float | None, float | None, float | None]


class Step(NamedTuple):
    """Step of a program, with lengths in m, in file coordinates.

    Attributes:
        line: line in the file.
        kind: "line", "arc", "offset" (G92), "forget" (G92.1), "suspend" (G92.2), "recall" (G92.3) or "stop".
        target: x, y, z; None if omitted.
        relative: True if the target is relative to the current position.
        machine: True if the target is absolute without offset (G53).
        plane: the two axes of an arc's plane, and its rotation axis.
        clockwise: sense of an arc, seen against that axis.
        centre: i, j, k; None if omitted.
        centre_relative: True if the centre is relative to the arc's start.
        radius: radius of an arc; None if it has a centre; negative for the longer arc.
        turns: number of turns of an arc, including the last partial one.
        speed: m/s; infinite for as fast as possible.
        duration: duration instead of a speed, s (G93).
        tolerance: corner deviation, m; None for that of the scenario.
        pause: s.
    """

    line: int
    kind: str
    target: Triple = (None, None, None)
    relative: bool = False
    machine: bool = False
    plane: tuple[int, int, int] = PLANES[17.0]
    clockwise: bool = False
    centre: Triple = (None, None, None)
    centre_relative: bool = True
    radius: float | None = None
    turns: int = 1
    speed: float = math.inf
    tolerance: float | None = None
    pause: float = 0.0
    duration: float | None = None


@dataclass(frozen=True, eq=False)
class Program(Frozen):
    """Content of a G-code file.

    Attributes:
        steps: steps in order.
        passed_over: words without motion, and ignored words.
        sha256: checksum of the file.
        spent: CPU time of reading, s.
    """

    steps: tuple[Step, ...] = field(repr=False)
    passed_over: tuple[str, ...]
    sha256: str
    spent: float = field(default=0.0, repr=False)
