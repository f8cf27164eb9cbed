"""G-code as steps: what the words of each line mean, in SI units, before it is known where the motion begins.

What moves nothing is passed over and its words are kept, to be told. What would move something in a way that is not
known here is a fault: a path that lacks a part is worse than none.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from cdpr.fields import MAX_DISTANCE
from cdpr.model.frozen import Frozen
from cdpr.scenario.motions.gcode_words import LINUXCNC, REPRAPFIRMWARE, LineError, Word, read_lines
from cdpr.scenario.motions.table import MAX_FAULTS, TableError

MAX_MOVES = 100_000
MAX_TURNS = 1000
MAX_PAUSE = 1e6  # s
SLOWEST = 1e-9  # m/s; a metre takes thirty years

METRES = {"mm": 1e-3, "inch": 0.0254, "m": 1.0}
DEFAULT_FEED = 0.05  # m/s, before the first F: RepRapFirmware's 3000 mm/min (its Configuration.h)

AXES = "XYZ"
CENTRE = "IJK"
PLANES = {17.0: (0, 1, 2), 18.0: (2, 0, 1), 19.0: (1, 2, 0)}  # first and second axis, and that of the turn

# G words that change nothing here: compensations and cycles off, the first coordinate system, of one dialect G94.
IDLE = {
    LINUXCNC: {40.0, 49.0, 50.0, 54.0, 69.0, 80.0, 97.0, 98.0, 99.0},
    REPRAPFIRMWARE: {10.0, 11.0, 40.0, 54.0, 80.0, 94.0},
}
# G words beside which coordinates are a move as without them: ignored, they go alone, and others with their line.
BESIDE = {LINUXCNC: {41.0, 42.0, 43.0, 55.0, 56.0, 57.0, 58.0, 59.0, 59.1, 59.2, 59.3}, REPRAPFIRMWARE: set[float]()}
OFFSETS = {10.0, 11.0}  # retraction, or the settings of a tool, of which its place is one
KNOWN = {
    LINUXCNC: {0.0, 1.0, 2.0, 3.0, 4.0, 17.0, 18.0, 19.0, 20.0, 21.0, 53.0, 61.0, 61.1, 64.0, 90.0, 90.1, 91.0, 91.1}
    | {92.0, 92.1, 92.2, 92.3, 93.0, 94.0},
    REPRAPFIRMWARE: {0.0, 1.0, 2.0, 3.0, 4.0, 17.0, 18.0, 19.0, 20.0, 21.0, 53.0, 90.0, 91.0, 92.0},
}
GROUPS = (
    {0.0, 1.0, 2.0, 3.0, 80.0},
    {17.0, 18.0, 19.0},
    {20.0, 21.0},
    {61.0, 61.1, 64.0},
    {90.0, 91.0},
    {90.1, 91.1},
    {93.0, 94.0},
)
# M words that end the program, that wait, and that would move or change what is known here.
ENDS = {LINUXCNC: {2.0, 30.0}, REPRAPFIRMWARE: {0.0, 1.0, 2.0, 30.0}}
WAITS = {LINUXCNC: {0.0, 1.0, 60.0}, REPRAPFIRMWARE: {226.0, 400.0}}
REFUSED = {
    LINUXCNC: {70.0, 71.0, 72.0, 73.0, 98.0, 99.0},
    REPRAPFIRMWARE: {24.0, 32.0, 98.0, 99.0, 120.0, 121.0, 206.0, 579.0},
}
SPEED_FACTOR = 220.0
SILENT = {LINUXCNC: "STDHLQ", REPRAPFIRMWARE: "STE"}  # letters that move nothing

IGNORABLE = r"G[0-9]+(\.[0-9]+)?|M[0-9]+|[A-EHLOQS-W]"  # words that may be passed over when it is said so

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
    """

    steps: tuple[Step, ...] = field(repr=False)
    passed_over: tuple[str, ...]
    sha256: str


@lru_cache(maxsize=4)  # the cases of a study name the same file
def parse_program(content: bytes, dialect: str, unit: str, ignore: tuple[str, ...]) -> Program:
    """Read a file's content; TableError lists what is wrong."""
    reader = _Reader(dialect, unit, set(ignore))
    faults: list[tuple[int, int, str]] = []
    for number, words in read_lines(content, dialect):
        try:
            if isinstance(words, LineError):
                raise words
            reader.line(number, words)
        except LineError as fault:
            faults.append((number, 0, str(fault)))
        if len(faults) == MAX_FAULTS or reader.ended:
            break
        if reader.moves > MAX_MOVES:
            faults.append((number, 0, f"{MAX_MOVES} moves at most are allowed: divide the file"))
            break
    if not faults and not reader.moves:
        faults.append((1, 0, "no move is in it: G0, G1, G2 or G3 with coordinates"))
    if faults:
        raise TableError(faults)
    passed_over = sorted(reader.passed_over, key=lambda name: (name[0], float(name[1:] or 0.0)))
    return Program(tuple(reader.steps), tuple(passed_over), hashlib.sha256(content).hexdigest())


class _Reader:
    """What holds from line to line."""

    def __init__(self, dialect: str, unit: str, ignore: set[str]) -> None:
        self.dialect, self.ignore = dialect, ignore
        self.known = KNOWN[dialect] | IDLE[dialect]
        self.steps: list[Step] = []
        self.passed_over: set[str] = set()
        self.moves = 0
        self.ended = False
        self.metres = METRES[unit]
        self.feed = None if dialect == LINUXCNC else DEFAULT_FEED
        self.inverse = False  # whether F is of each move, 1/min
        self.factor = 1.0
        self.motion: float | None = None if dialect == LINUXCNC else 1.0
        self.relative, self.centre_relative = False, True
        self.plane = PLANES[17.0]
        self.tolerance: float | None = None

    def line(self, number: int, words: list[Word]) -> None:
        """Take one line."""
        codes, others, machine_words = self._sorted(words)
        if codes is None:
            return
        self._modes(codes, others)
        if self.inverse:
            self.feed = others.pop("F", 0.0) / 60.0
        elif "F" in others:
            self.feed = others.pop("F") * self.metres / 60.0
            if not self.feed >= SLOWEST:
                raise LineError(f"F: a feed of {SLOWEST:g} m/s or more is expected, got {self.feed:g} m/s")
        if 4.0 in codes:
            self._pause(number, others)
        for code in (92.0, 92.1, 92.2, 92.3):
            if code in codes:
                if code == 92.0 and self.dialect == LINUXCNC and not others.keys() & set(AXES):
                    raise LineError("G92: where the motion is to be, X, Y or Z, is expected")
                kind = {92.0: "offset", 92.1: "forget", 92.2: "suspend", 92.3: "recall"}[code]
                target = self._triple(others, AXES) if code == 92.0 else (None, None, None)
                self.steps.append(Step(number, kind, target))
        if any(letter in others for letter in AXES + CENTRE + "R") or codes & {2.0, 3.0}:
            # RepRapFirmware's G92 moves the machine's coordinates, and other offsets are not known here.
            self._move(number, others, 53.0 in codes and self.dialect == LINUXCNC)
        self._machine(number, machine_words)
        for name, value in others.items():
            if name in SILENT[self.dialect]:
                self.passed_over.add(name)
            elif not machine_words:  # to which it may belong
                raise LineError(f"{name}{value:g} means nothing here{self._way_out(name)}")

    def _sorted(self, words: Iterable[Word]) -> tuple[set[float] | None, dict[str, float], list[Word]]:
        """Return the line's G codes, its numbers by their letters, and the M words; no codes where it is ignored."""
        codes: set[float] = set()
        others: dict[str, float] = {}
        machine: list[Word] = []
        words = list(words)
        for word in words:
            if word.letter == "G" and word.name in self.ignore:
                self.passed_over.add(word.name)
                if word.value not in BESIDE[self.dialect]:
                    return None, {}, []
        for k, word in enumerate(words):
            letter, value = word
            if letter == "M" and self.dialect == REPRAPFIRMWARE:
                machine = words[k:]
                break
            if letter == "M":
                machine.append(word)
                continue
            if letter in self.ignore:
                self.passed_over.add(letter)
                continue
            if letter == "G" and word.name in self.ignore:
                continue
            if value is None:
                raise LineError(f"{letter}: a number is expected after it")
            if letter == "G":
                if value in codes:
                    raise LineError(f"{word.name} stands here twice")
                self._known(word, value)
                codes.add(value)
            elif letter in others:
                raise LineError(f"{letter} stands here twice")
            else:
                others[letter] = value
        if codes & OFFSETS:
            self._retraction(others)
            return None, {}, []
        for group in GROUPS:
            if len(codes & group) > 1:
                raise LineError(f"{' and '.join(f'G{code:g}' for code in sorted(codes & group))} exclude each other")
        return codes, others, machine

    def _known(self, word: Word, value: float) -> None:
        if value not in self.known:
            known = ", ".join(f"G{code:g}" for code in sorted(KNOWN[self.dialect]))
            raise LineError(f"{word.name} is not known here, only {known}{self._way_out(word.name)}")

    def _retraction(self, others: dict[str, float]) -> None:
        """Pass over G10 and G11 where they retract filament or set temperatures, not where they move coordinates."""
        moved = [name for name in ("L", *AXES) if name in others]
        if moved:
            raise LineError(f"G10 with {moved[0]} moves the coordinates, which is not known here{self._way_out('G10')}")
        self.passed_over.add("G10")

    def _way_out(self, name: str) -> str:
        dialect = f"; the dialect is {self.dialect}"
        if name == "E" and self.dialect == LINUXCNC:
            dialect += f", and files for 3D printers, where it is filament, are of {REPRAPFIRMWARE}"
        if not re.fullmatch(IGNORABLE, name):
            return dialect
        return f"{dialect}; to pass over it, as if it moved nothing, write ignore: [{name}]"

    def _modes(self, codes: set[float], others: dict[str, float]) -> None:
        for code in codes:
            if code in PLANES:
                self.plane = PLANES[code]
            elif code in (20.0, 21.0):
                self.metres = METRES["inch" if code == 20.0 else "mm"]
            elif code in (90.0, 91.0):
                self.relative = code == 91.0
            elif code in (93.0, 94.0) and self.inverse != (code == 93.0):
                self.inverse, self.feed = code == 93.0, None
            elif code in (90.1, 91.1):
                self.centre_relative = code == 91.1
            elif code in (61.0, 61.1):
                self.tolerance = 0.0
            elif code <= 3.0:
                self.motion = code
            elif code == 80.0:
                self.motion = None
        if 64.0 in codes:
            self.tolerance = None
            if "P" in others:
                self.tolerance = others.pop("P") * self.metres
                if self.tolerance < 0.0:
                    raise LineError("P: a tolerance of 0 or more is expected")
            if "Q" in others:
                others.pop("Q")

    def _pause(self, number: int, others: dict[str, float]) -> None:
        """A dwell: LinuxCNC's P is in s. RepRapFirmware's S is in s, else its P in ms; without time it does nothing."""
        if self.dialect == REPRAPFIRMWARE:
            milliseconds = others.pop("P", 0.0)
            pause = others.pop("S", 1e-3 * milliseconds)
            if pause <= 0.0:
                self.passed_over.add("G4")
                return
        elif "P" in others:
            pause = others.pop("P")
        else:
            raise LineError("G4: P, how long in s, is expected")
        self.moves += 1
        if not 0.0 <= pause <= MAX_PAUSE:
            raise LineError(f"G4: a pause between 0 and {MAX_PAUSE:g} s is expected, got {pause:g} s")
        self.steps.append(Step(number, "stop", pause=pause))

    def _move(self, number: int, others: dict[str, float], machine: bool) -> None:
        if self.motion is None:
            raise LineError("coordinates without a motion: G0, G1, G2 or G3 is expected before them")
        self.moves += 1
        target = self._triple(others, AXES)
        speed, duration = self._pace()
        step = Step(
            number, "line", target, self.relative, machine, speed=speed, tolerance=self.tolerance, duration=duration
        )
        if self.motion < 2.0:
            self.steps.append(step)
            return
        centre = self._triple(others, "".join(CENTRE[axis] for axis in sorted(self.plane[:2])), self.plane)
        radius, turns = others.pop("R", None), others.pop("P", 1.0)
        if radius is None and centre == (None, None, None):
            letters = " and ".join(CENTRE[axis] for axis in self.plane[:2])
            holds = f"G{self.motion:g} holds until G0 or G1 ends it"
            raise LineError(f"an arc needs its centre, {letters}, or its radius R; {holds}")
        if radius is not None and centre != (None, None, None):
            raise LineError("an arc has a centre or a radius R, not both")
        if radius is None and not self.centre_relative and None in [centre[axis] for axis in self.plane[:2]]:
            raise LineError("both coordinates of an arc's centre are expected, for G90.1 counts them from the origin")
        if turns != int(turns) or not 1 <= turns <= MAX_TURNS:
            raise LineError(f"P: a whole number of turns from 1 to {MAX_TURNS} is expected, got {turns:g}")
        self.steps.append(
            Step(
                number,
                "arc",
                target,
                self.relative,
                machine,
                self.plane,
                self.motion == 2.0,
                centre,
                self.centre_relative,
                None if radius is None else radius * self.metres,
                int(turns),
                speed,
                self.tolerance,
                duration=duration,
            )
        )

    def _pace(self) -> tuple[float, float | None]:
        """Return the speed that is wanted of a move, m/s, infinite for the fastest, or else how long it lasts, s."""
        if self.motion == 0.0 and self.dialect == LINUXCNC:
            return math.inf, None
        if self.inverse:
            if not self.feed or not 0.0 < 1.0 / self.feed <= MAX_PAUSE:
                least = f"{60.0 / MAX_PAUSE:g} or more"
                raise LineError(
                    f"under G93 each line with G1, G2 or G3 has an F, how often it fits into a minute: {least}"
                )
            return math.inf, 1.0 / self.feed
        if self.feed is None:
            raise LineError("no feed yet: an F is expected before the first move by G1, G2 or G3")
        return self.feed * self.factor, None

    def _triple(self, others: dict[str, float], letters: str, plane: tuple[int, int, int] = (0, 1, 2)) -> Triple:
        """Take coordinates, in m."""
        found: list[float | None] = [None, None, None]
        for letter in letters:
            if letter in others:
                value = others.pop(letter) * self.metres
                if not abs(value) <= MAX_DISTANCE:
                    raise LineError(f"{letter}: {value:g} m is farther than {MAX_DISTANCE:g} m")
                found[(AXES if letter in AXES else CENTRE).index(letter)] = value
        return (found[0], found[1], found[2])

    def _machine(self, number: int, words: list[Word]) -> None:
        """Take the M words: what ends or waits, and RepRapFirmware's factor of the speed."""
        for k, word in enumerate(words):
            if word.letter != "M":
                continue
            if word.value is None or word.value < 0.0:
                raise LineError("M: a number of 0 or more is expected after it")
            if word.value in REFUSED[self.dialect] and word.name not in self.ignore:
                raise LineError(f"{word.name} runs or changes what is not known here{self._way_out(word.name)}")
            if word.value in ENDS[self.dialect]:
                self.ended = True
            elif word.value in WAITS[self.dialect]:
                self.steps.append(Step(number, "stop"))
                self.passed_over.add(word.name)
            elif self.dialect == REPRAPFIRMWARE and word.value == SPEED_FACTOR and word.name not in self.ignore:
                factor = next((other.value for other in words[k + 1 :] if other.letter == "S"), None)
                if factor is not None:
                    if not 1e-3 <= factor <= 1e4:
                        raise LineError(f"M220: S, a percentage greater than 0, is expected, got {factor:g}")
                    self.factor = 0.01 * factor
            else:
                self.passed_over.add(word.name)
