"""G-code interpreter: converts words into steps in SI units, independent of the start of the motion.

Words without motion are skipped and reported. Unknown words that could cause motion are errors, because an incomplete
path is worse than none.
"""

from __future__ import annotations

import hashlib
import math
import re
from functools import lru_cache

from cdpr.base.fields import MAX_DISTANCE
from cdpr.base.files import MAX_FAULTS, ContentError, CpuBudget
from cdpr.gcode.steps import Program, Step, Triple
from cdpr.gcode.tables import (
    AXES,
    BESIDE,
    CANCEL,
    CENTRE,
    DEFAULT_FEED,
    ENDS,
    IDLE,
    IGNORABLE,
    KNOWN,
    METRES,
    MOTIONS,
    MOTOR_MODE,
    MOTOR_WORDS,
    OFFSETS,
    PLANES,
    REFUSED,
    SILENT,
    SPEED_FACTOR,
    WAITS,
    conflict,
)
from cdpr.gcode.words import DIVIDE, LINUXCNC, REPRAPFIRMWARE, LineError, Word, read_lines

MAX_MOVES = 100_000
MAX_TURNS = 1000
MAX_PAUSE = 1e6  # s
SLOWEST = 1e-9  # m/s; a metre takes thirty years


@lru_cache(maxsize=4)  # cases of a study use the same file
def parse_program(content: bytes, dialect: str, unit: str, ignore: tuple[str, ...]) -> Program:
    """Return the program in a file's content; raise ContentError if it is invalid."""
    reader = _Reader(dialect, unit, set(ignore))
    faults: list[tuple[int, int, str]] = []
    budget = CpuBudget(remedy=DIVIDE)
    try:
        for number, words in read_lines(content, dialect, budget.check):
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
    except ContentError as unreadable:
        faults += unreadable.faults
    if not faults and not reader.moves:
        faults.append((1, 0, "no move is in it: G0, G1, G2 or G3 with coordinates"))
    if faults:
        raise ContentError(faults)
    passed_over = sorted(reader.passed_over, key=_order)
    checksum = hashlib.sha256(content).hexdigest()
    return Program(tuple(reader.steps), tuple(passed_over), checksum, budget.spent)


def _order(name: str) -> tuple[str, float]:
    """Return the sort key of a word: by letter, then by number."""
    number = re.fullmatch(r"([A-Z])([0-9.]+)", name)
    return (number[1], float(number[2])) if number else (name, 0.0)


class _Reader:
    """Modal state of the interpreter."""

    def __init__(self, dialect: str, unit: str, ignore: set[str]) -> None:
        self.dialect, self.ignore = dialect, ignore
        self.known = KNOWN[dialect] | IDLE[dialect]
        self.steps: list[Step] = []
        self.passed_over: set[str] = set()
        self.moves = 0
        self.ended = False
        self.program_number: float | None = None
        self.metres = METRES[unit]
        self.feed = None if dialect == LINUXCNC else DEFAULT_FEED
        self.inverse = False  # True if F is per move, 1/min
        self.factor = 1.0
        self.motion: float | None = None if dialect == LINUXCNC else 1.0
        self.relative, self.centre_relative = False, True
        self.plane = PLANES[17.0]
        self.tolerance: float | None = None

    def line(self, number: int, words: list[Word]) -> None:
        """Process one line."""
        if len(words[0].letter) > 1:
            self._command(words[0].letter)
            return
        if words[0].letter == "O" and self.dialect == LINUXCNC:
            self._program_number(words[0])
            return
        codes, others, machine_words = self._sorted(words)
        self._modes(codes, others)
        if self.inverse:
            self.feed = others.pop("F", 0.0) / 60.0
        elif "F" in others:
            self.feed = others.pop("F") * self.metres / 60.0
            if not self.feed >= SLOWEST:
                raise LineError(f"F: expected a feed of {SLOWEST:g} m/s or more, got {self.feed:g} m/s")
        if 4.0 in codes:
            self._pause(number, others)
        for code in (92.0, 92.1, 92.2, 92.3):
            if code in codes:
                known = others.keys() & set(AXES) or any(word.letter in self.ignore for word in words)
                if code == 92.0 and self.dialect == LINUXCNC and not known:
                    raise LineError("G92: expected the new position, X, Y or Z")
                kind = {92.0: "offset", 92.1: "forget", 92.2: "suspend", 92.3: "recall"}[code]
                target = self._triple(others, AXES) if code == 92.0 else (None, None, None)
                self.steps.append(Step(number, kind, target))
        if any(letter in others for letter in AXES + CENTRE + "R") or codes & {2.0, 3.0}:
            # RepRapFirmware's G92 changes the machine's coordinates; other offsets are not supported.
            self._move(number, others, 53.0 in codes and self.dialect == LINUXCNC)
        self._machine(number, machine_words)
        for name, value in others.items():
            if name in SILENT[self.dialect]:
                self.passed_over.add(name)
            elif not machine_words:  # it may be a parameter of these
                raise LineError(f"{name}{value:g} is not supported{self._way_out(name)}")

    def _command(self, name: str) -> None:
        """Skip a command of other firmware that is listed in `ignore`."""
        if name not in self.ignore:
            raise LineError(f"{name} is a command of other firmware, which is not supported{self._way_out(name)}")
        self.passed_over.add(name)

    def _program_number(self, word: Word) -> None:
        """Skip the program number. A second one starts a subprogram, which runs only when called."""
        if self.program_number is not None or self.moves:
            raise LineError(
                f"{word.name} begins a subprogram, which is not supported: expected a single program number, "
                "before the first move; replace each call by the moves of the subprogram, or remove it"
            )
        self.program_number = word.value
        self.passed_over.add(word.name)

    def _sorted(self, words: list[Word]) -> tuple[set[float], dict[str, float], list[Word]]:
        """Return the line's G codes, its numbers by letter, and the M words."""
        codes: set[float] = set()
        others: dict[str, float] = {}
        machine: list[Word] = []
        skipped = False  # an ignored word also takes the coordinates
        for k, word in enumerate(words):
            letter, value = word
            if letter == "M" and self.dialect == REPRAPFIRMWARE:
                machine = words[k:]
                break
            if letter == "M":
                machine.append(word)
                continue
            if letter in self.ignore or (letter == "G" and word.name in self.ignore):
                self.passed_over.add(word.name if letter == "G" else letter)
                skipped = skipped or (letter == "G" and value not in BESIDE[self.dialect]) or self._moves_motors(word)
                continue
            if letter == "G":
                if value is None:
                    raise LineError("G: expected a number after it")
                if value in codes:
                    raise LineError(f"{word.name} occurs twice")
                self._known(word, value)
                codes.add(value)
            elif letter in others:
                raise LineError(f"{letter} occurs twice")
            else:
                others[letter] = math.nan if value is None else value
        if skipped:
            others = {letter: value for letter, value in others.items() if letter == "F"}
        bare = [letter for letter, value in others.items() if math.isnan(value)]
        if bare:
            raise LineError(f"{bare[0]}: expected a number after it")
        if self._moves_motors(Word(MOTOR_MODE, others.get(MOTOR_MODE))):
            raise self._motors(f"{MOTOR_MODE}{others[MOTOR_MODE]:g}")
        if self.dialect == REPRAPFIRMWARE:
            others.pop(MOTOR_MODE, None)  # H0: a usual move
        if codes & OFFSETS:
            self._retraction(codes, others)
            return codes - OFFSETS, {}, machine
        excluded = conflict(codes, self.dialect, "P" in others)
        if excluded:
            raise LineError(excluded)
        if codes & MOTIONS:
            codes.discard(CANCEL)
        return codes, others, machine

    def _moves_motors(self, word: Word) -> bool:
        """Return True if a word makes the coordinates of its line those of single motors."""
        return self.dialect == REPRAPFIRMWARE and word.letter == MOTOR_MODE and bool(word.value)

    def _motors(self, name: str) -> LineError:
        return LineError(
            f"{name} moves single motors, such as winches, not the platform, which is not supported: remove the line, "
            f"or write ignore: [{name if name[0] == 'G' else name[0]}] to skip its coordinates"
        )

    def _known(self, word: Word, value: float) -> None:
        if value in MOTOR_WORDS[self.dialect]:
            raise self._motors(word.name)
        if value not in self.known:
            known = ", ".join(f"G{code:g}" for code in sorted(KNOWN[self.dialect]))
            raise LineError(f"{word.name} is not supported, only {known}{self._way_out(word.name)}")

    def _retraction(self, codes: set[float], others: dict[str, float]) -> None:
        """Skip G10 and G11 if they retract filament or set temperatures; reject changes of coordinates."""
        if codes - OFFSETS:
            raise LineError("G10 or G11 beside other G words: put it on a separate line")
        moved = [name for name in ("L", *AXES) if name in others]
        if moved:
            raise LineError(f"G10 with {moved[0]} moves the coordinates, which is not supported{self._way_out('G10')}")
        self.passed_over.add("G10")

    def _way_out(self, name: str) -> str:
        dialect = f"; the dialect is {self.dialect}"
        if name == "E" and self.dialect == LINUXCNC:
            dialect += f", and files for 3D printers, where it is filament, are of {REPRAPFIRMWARE}"
        if not re.fullmatch(IGNORABLE, name):
            return dialect
        return f"{dialect}; to skip it, as if without motion, write ignore: [{name}]"

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
                    raise LineError("P: expected a tolerance of 0 or more")
            if "Q" in others:
                others.pop("Q")

    def _pause(self, number: int, others: dict[str, float]) -> None:
        """Process a dwell: P is in s for LinuxCNC; for RepRapFirmware S is in s and P in ms, default none."""
        if self.dialect == REPRAPFIRMWARE:
            milliseconds = others.pop("P", 0.0)
            pause = others.pop("S", 1e-3 * milliseconds)
            if pause <= 0.0:
                self.passed_over.add("G4")
                return
        elif "P" in others:
            pause = others.pop("P")
        else:
            raise LineError("G4: expected P, how long in s")
        self.moves += 1
        if not 0.0 <= pause <= MAX_PAUSE:
            raise LineError(f"G4: expected a pause between 0 and {MAX_PAUSE:g} s, got {pause:g} s")
        self.steps.append(Step(number, "stop", pause=pause))

    def _move(self, number: int, others: dict[str, float], machine: bool) -> None:
        if self.motion is None:
            raise LineError("coordinates without a motion: expected G0, G1, G2 or G3 before them")
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
            raise LineError("expected both coordinates of an arc's centre, for G90.1 counts them from the origin")
        if turns != int(turns) or not 1 <= turns <= MAX_TURNS:
            raise LineError(f"P: expected a whole number of turns from 1 to {MAX_TURNS}, got {turns:g}")
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
        """Return the speed of a move, m/s (infinite: as fast as possible), or its duration, s."""
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
            raise LineError("no feed yet: expected an F before the first move by G1, G2 or G3")
        return self.feed * self.factor, None

    def _triple(self, others: dict[str, float], letters: str, plane: tuple[int, int, int] = (0, 1, 2)) -> Triple:
        """Remove and return coordinates, m."""
        found: list[float | None] = [None, None, None]
        for letter in letters:
            if letter in others:
                value = others.pop(letter) * self.metres
                if not abs(value) <= MAX_DISTANCE:
                    raise LineError(f"{letter}: {value:g} m is farther than {MAX_DISTANCE:g} m")
                found[(AXES if letter in AXES else CENTRE).index(letter)] = value
        return (found[0], found[1], found[2])

    def _machine(self, number: int, words: list[Word]) -> None:
        """Process the M words: program end, waiting, and RepRapFirmware's speed factor."""
        for k, word in enumerate(words):
            if word.letter != "M":
                continue
            if word.value is None or word.value < 0.0:
                raise LineError("M: expected a number of 0 or more after it")
            if word.value in REFUSED[self.dialect] and word.name not in self.ignore:
                raise LineError(f"{word.name} runs or changes an unsupported function{self._way_out(word.name)}")
            if word.value in ENDS[self.dialect]:
                self.ended = True
            elif word.value in WAITS[self.dialect]:
                self.steps.append(Step(number, "stop"))
                self.passed_over.add(word.name)
            elif self.dialect == REPRAPFIRMWARE and word.value == SPEED_FACTOR and word.name not in self.ignore:
                factor = next((other.value for other in words[k + 1 :] if other.letter == "S"), None)
                if factor is not None:
                    if not 1e-3 <= factor <= 1e4:
                        raise LineError(f"M220: expected S, a percentage greater than 0, got {factor:g}")
                    self.factor = 0.01 * factor
            else:
                self.passed_over.add(word.name)
