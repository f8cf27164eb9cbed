"""Conversion of G-code steps into a path in the world, from a given start."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cdpr.base.fields import MAX_DISTANCE
from cdpr.base.files import MAX_FAULTS, ContentError, CpuBudget
from cdpr.gcode.course import Course
from cdpr.gcode.curves import arcs as arc_curves
from cdpr.gcode.curves import lines
from cdpr.gcode.steps import Program, Step
from cdpr.gcode.words import DIVIDE, EACH, checked
from cdpr.model import rotations
from cdpr.model.robot import Array

# Largest difference of an arc's radii at start and end: the larger of a length (m) and a fraction of the radius, as in
# LinuxCNC, because files have three or four decimals. The radius then changes along the arc.
SPIRAL, SPIRAL_SHARE = 3e-5, 1e-3

# An arc of a smaller angle, rad, is a full turn.
FUZZ = 1e-6

NO_WAY = 1e-12  # m; shorter steps are ignored

Point = tuple[float, float]

ROUNDING = 1e-15  # smaller entries of a rotation matrix are set to zero


@dataclass(frozen=True)
class Placing:
    """Transformation from file coordinates to the world.

    Attributes:
        origin: origin of the file's coordinates, m, world.
        attitude: attitude of the file's axes, a quaternion, world.
        scale: factor of lengths.
    """

    origin: tuple[float, float, float]
    attitude: tuple[float, ...]
    scale: float

    @cached_property
    def axes(self) -> Array:
        """Rotation matrix (3, 3) from file to world axes, free of round-off in zeros: right angles stay exact."""
        matrix = rotations.matrix(np.array(self.attitude))
        return np.where(np.abs(matrix) < ROUNDING, 0.0, matrix)

    def world(self, points: Array) -> Array:
        """Return points (K, 3) of the file, m, in world coordinates."""
        return np.asarray(np.array(self.origin) + self.scale * points @ self.axes.T)

    def file(self, point: Array) -> Array:
        """Return a world point (3,), m, in file coordinates."""
        return np.asarray(self.axes.T @ (point - self.origin) / self.scale)


@dataclass(frozen=True, eq=False)
class Path:
    """Path of N pieces.

    Attributes:
        course: the pieces; None if there is no motion.
        lines: (N,), line of each piece in the file.
        delay: pause before the first piece, s.
        spent: CPU time of reading and following the program, s.
    """

    course: Course | None
    lines: NDArray[np.int64]
    delay: float
    spent: float = 0.0


@dataclass
class _Laid:
    """Accumulator of pieces: ends, speeds and tolerances, and the data of arcs.

    Flat lists of numbers, because many small objects would dominate the time.
    """

    lines: list[int] = field(default_factory=list)
    ends: list[float] = field(default_factory=list)
    arcs: list[int] = field(default_factory=list)
    round: list[float] = field(default_factory=list)
    speed: list[float] = field(default_factory=list)
    duration: dict[int, float] = field(default_factory=dict)  # durations that replace a speed
    tolerance: list[float] = field(default_factory=list)
    stop: list[bool] = field(default_factory=list)
    pause: list[float] = field(default_factory=list)
    delay: float = 0.0


@lru_cache(maxsize=4)
def build_path(program: Program, placing: Placing, begin: tuple[float, float, float], tolerance: float) -> Path:
    """Follow a program from a position, m, world; raise ContentError with moves that are impossible.

    `tolerance` is the corner deviation, m, if the program does not set it.
    """
    laid = _Laid()
    faults: list[tuple[int, int, str]] = []
    first = here = placing.file(np.array(begin)).tolist()
    offset, kept = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    budget = CpuBudget(remedy=DIVIDE, spent=program.spent)
    for count, step in enumerate(program.steps, 1):
        if count % EACH == 0:
            checked(budget.check, step.line)
        if step.kind == "stop":
            _stop(laid, step.pause)
        elif step.kind == "offset":
            for axis, value in enumerate(step.target):
                if value is not None:
                    offset[axis] = kept[axis] = here[axis] - value
        elif step.kind == "forget":
            offset, kept = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        elif step.kind == "suspend":
            offset = [0.0, 0.0, 0.0]
        elif step.kind == "recall":
            offset = list(kept)
        else:
            there = _target(step, here, offset)
            if step.kind == "arc":
                try:
                    laid.round += _arc(step, here, there, offset)
                except ValueError as error:
                    faults.append((step.line, 0, str(error)))
                    if len(faults) == MAX_FAULTS:
                        break
                    here = there
                    continue
                laid.arcs.append(len(laid.lines))
            elif math.dist(here, there) * placing.scale <= NO_WAY:
                continue
            if step.duration is not None:
                laid.duration[len(laid.lines)] = step.duration
            laid.lines.append(step.line)
            laid.ends += there
            laid.speed.append(step.speed)
            laid.tolerance.append(tolerance if step.tolerance is None else step.tolerance * placing.scale)
            laid.stop.append(False)
            laid.pause.append(0.0)
            here = there
    ends = placing.world(np.array([*first, *laid.ends]).reshape(-1, 3))
    arcs = _Arcs.of(np.array(laid.round).reshape(-1, _Arcs.NUMBERS), placing)
    faults += _far(laid, ends, arcs)
    if faults:
        raise ContentError(sorted(faults)[:MAX_FAULTS])
    course = _course(laid, ends, arcs)
    return Path(course, np.array(laid.lines, dtype=np.int64), laid.delay, budget.spent)


def _stop(laid: _Laid, pause: float) -> None:
    if laid.lines:
        laid.stop[-1] = True
        laid.pause[-1] += pause
    else:
        laid.delay += pause


def _target(step: Step, here: list[float], offset: list[float]) -> list[float]:
    """Return the end of a step, in file coordinates without offset."""
    there = list(here)
    for axis, value in enumerate(step.target):
        if value is None:
            continue
        if step.machine:
            there[axis] = value
        else:
            there[axis] = value + (here[axis] if step.relative else offset[axis])
    return there


def _arc(step: Step, here: list[float], there: list[float], offset: list[float]) -> list[float]:
    """Return the numbers of an arc in file coordinates, as in `_Arcs`; raise ValueError if it is invalid."""
    first, second, turn = step.plane
    begin, end = (here[first], here[second]), (there[first], there[second])
    if step.radius is not None:
        middle = _middle(begin, end, step.radius, step.clockwise)
    else:
        base = begin if step.centre_relative else (0.0, 0.0) if step.machine else (offset[first], offset[second])
        middle = base[0] + (step.centre[first] or 0.0), base[1] + (step.centre[second] or 0.0)
    x0, y0, x1, y1 = begin[0] - middle[0], begin[1] - middle[1], end[0] - middle[0], end[1] - middle[1]
    r0, r1 = math.hypot(x0, y0), math.hypot(x1, y1)
    if r0 <= NO_WAY or r1 <= NO_WAY:
        raise ValueError("the centre of the arc coincides with its start or end")
    if abs(r1 - r0) > max(SPIRAL, SPIRAL_SHARE * r0):
        raise ValueError(
            f"no arc: its centre is {r0:.9g} m from where it begins and {r1:.9g} m from where it ends; "
            f"{max(SPIRAL, SPIRAL_SHARE * r0):.2g} m of difference are allowed"
        )
    sense = -1.0 if step.clockwise else 1.0
    angle = (sense * (math.atan2(y1, x1) - math.atan2(y0, x0))) % (2.0 * math.pi)
    if angle < FUZZ or 2.0 * math.pi - angle < FUZZ:
        # With a radius, the ends differ, so that a full turn is impossible.
        angle = 2.0 * math.pi
    angle += 2.0 * math.pi * (step.turns - 1)
    centre, out, on, climb = [0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3
    centre[first], centre[second], centre[turn] = *middle, here[turn]
    out[first], out[second] = x0 / r0, y0 / r0
    on[first], on[second] = -sense * y0 / r0, sense * x0 / r0
    climb[turn] = there[turn] - here[turn]
    growth = r1 if abs(r1 - r0) > NO_WAY else r0
    return [*centre, *out, *on, *climb, r0, growth, angle]


def _middle(begin: Point, end: Point, radius: float, clockwise: bool) -> Point:
    """Return the centre of an arc of a radius, m; a positive radius means less than half a turn."""
    x, y = end[0] - begin[0], end[1] - begin[1]
    length = math.hypot(x, y)
    if length <= NO_WAY:
        raise ValueError("the arc with a radius R ends at its start: give its centre instead")
    away = radius**2 - 0.25 * length**2
    if away < -max(2.0 * SPIRAL * abs(radius), SPIRAL_SHARE * radius**2):
        raise ValueError(f"no arc of radius {abs(radius):.9g} m reaches over {length:.9g} m, more than twice of it")
    # For a left turn, the centre of the shorter arc is on the left.
    side = (-1.0 if clockwise else 1.0) * (1.0 if radius > 0.0 else -1.0)
    share = side * math.sqrt(max(away, 0.0)) / length
    return begin[0] + 0.5 * x - share * y, begin[1] + 0.5 * y + share * x


@dataclass(frozen=True, eq=False)
class _Arcs:
    """Arcs in the world, K, for `cdpr.gcode.curves.arcs`."""

    NUMBERS: ClassVar[int] = 15

    centre: Array
    out: Array
    on: Array
    radii: Array
    angle: Array
    climb: Array

    @classmethod
    def of(cls, numbers: Array, placing: Placing) -> _Arcs:
        """Return arcs from numbers (K, 15): centre, unit vectors out and on, climb, both radii, angle."""
        centre, out, on, climb = (numbers[:, k : k + 3] for k in range(0, 12, 3))
        out, on, climb = (vectors @ placing.axes.T for vectors in (out, on, climb))
        radii, climb = placing.scale * numbers[:, 12:14], placing.scale * climb
        return cls(placing.world(centre), out, on, radii, numbers[:, 14], climb)


def _far(laid: _Laid, ends: Array, arcs: _Arcs) -> list[tuple[int, int, str]]:
    """Return an error for the first position that is too far away."""
    reach = np.abs(ends[1:]).max(axis=1)
    which = np.array(laid.arcs, dtype=np.int64)
    reach[which] = np.maximum(reach[which], np.abs(arcs.centre).max(axis=1) + arcs.radii.max(axis=1))
    wrong = np.flatnonzero(~(reach <= MAX_DISTANCE))[:1]
    return [(laid.lines[k], 0, f"leads {reach[k]:.4g} m from the origin, {MAX_DISTANCE:g} m at most") for k in wrong]


def _course(laid: _Laid, ends: Array, arcs: _Arcs) -> Course | None:
    if not laid.lines:
        return None
    pieces = lines(ends[:-1], ends[1:])
    round_ones = arc_curves(arcs.centre, arcs.out, arcs.on, arcs.radii, arcs.angle, arcs.climb)
    pieces.replace(np.array(laid.arcs, dtype=np.int64), round_ones)
    pause, speed = np.array(laid.pause), np.array(laid.speed)
    timed = np.array(list(laid.duration), dtype=np.int64)
    with np.errstate(over="ignore"):  # the limits apply then
        speed[timed] = pieces.length[timed] / np.array(list(laid.duration.values()))
    return Course(pieces, speed, np.array(laid.tolerance), np.array(laid.stop), pause)


def farthest(course: Course, quarters: int = 4) -> Array:
    """Return the extreme positions (K, 3), m, along each axis; arcs are sampled at quarters of their length."""
    pieces = course.pieces
    found = []
    for share in np.linspace(0.0, 1.0, quarters + 1):
        found.append(pieces.at(np.arange(len(pieces)), share * pieces.length)[0])
    points = np.concatenate(found)
    rows = {*points.argmin(axis=0).tolist(), *points.argmax(axis=0).tolist()}
    return np.asarray(points[sorted(rows)])
