"""Steps of a G-code program, in SI units, before its beginning is known."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from cdpr.model.frozen import Frozen
from cdpr.scenario.motions.gcode_tables import PLANES

Triple = tuple[float | None, float | None, float | None]


class Step(NamedTuple):
    """One thing that a line asks for, lengths in m as the file has them.

    Attributes:
        line: where it stands.
        kind: "line", "arc", "offset" (G92), "forget" (G92.1), "suspend" (G92.2), "recall" (G92.3) or "stop".
        target: x, y, z, None where left out.
        relative: whether they count from where the motion is.
        machine: whether they count from the file's origin without the offset, and never from where the motion is (G53).
        plane: the two axes of an arc's plane, and that of its turn.
        clockwise: the sense of an arc, seen against that axis.
        centre: i, j, k, None where left out.
        centre_relative: whether they count from an arc's beginning.
        radius: of an arc, None where it has a centre; negative for the longer way round.
        turns: of an arc, begun.
        speed: wanted, m/s; infinite for as fast as possible.
        duration: at the speed that is wanted, in place of it, s (G93).
        tolerance: by which a corner may be missed, m; None for what the scenario says.
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
    """Contents of a file.

    Attributes:
        steps: in their order.
        passed_over: words that move nothing, or that are to be ignored.
        sha256: checksum of the file.
        spent: CPU time that reading took, s.
    """

    steps: tuple[Step, ...] = field(repr=False)
    passed_over: tuple[str, ...]
    sha256: str
    spent: float = field(default=0.0, repr=False)
