"""Reader of Hangprinter configurations of RepRapFirmware: `M669 K6` and `M666` in `config.g`.

M669 has the anchors, mm: N of the letters A, B, C, D, I, J, K, L, O, 4 by default. M666 has the spools, the
mass of the effector, the forces and the stiffness of the lines. Older versions have the spools in M669, and only the
height of anchor D. Later lines replace the values of earlier ones, as in the firmware.

The firmware's flex compensation stretches a direction by F d / S (no guy lines): force F, distance d, S of M666. So S
is the axial stiffness of the cable that replaces its lines. Spools that grow, lines on them and mechanical advantages
have the equations of our drums (`cdpr.cables.transmission`).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from cdpr.formats.read.gcode_commands import Command, Commands, commands_of
from cdpr.formats.read.hangprinter import MM, Line, Printer, complete
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, refuse, slug

LETTERS = "ABCDIJKLO"  # of anchors
KINEMATICS = ("M669", "M666")
HANGPRINTER = 6.0  # kinematics type K
DEFAULT_ANCHORS = 4
FEWEST = 3

# Letters of values per line, in M666 and, in older versions, in M669.
RADIUS, MASS, STIFFNESS, LOW, HIGH = "R", "W", "S", "I", "X"
GROWTH, LINES, ADVANTAGE, SPOOL_TEETH, MOTOR_TEETH, OLD_MOTOR_TEETH = "Q", "O", "U", "H", "L", "G"
# Defaults of the firmware, those of a Hangprinter 4; mm for the first two.
DEFAULT_RADIUS, DEFAULT_GROWTH, DEFAULT_SPOOL_TEETH, DEFAULT_MOTOR_TEETH = 75.0, 0.007, 255.0, 20.0
DEFAULT_ADVANTAGE, DEFAULT_LAST_ADVANTAGE = 2.0, 4.0  # of the last line, which holds the weight
DEFAULT = "default of the firmware"
OLDER = "QWRUOGLHJ"  # letters of M669 in older versions that are not anchors

NOT_IMPORTED = {
    "A": "the region that the firmware permits",
    "B": "an option of the firmware's flex compensation",
    "C": "torque constants of motors: ideal drives have none",
    "F": "the firmware's flex compensation; here it is an option of the controller, `flex_compensation`",
    "J": "steps per revolution: drives that follow lengths exactly have no steps",
    "P": "an option of the firmware's flex compensation",
    "Y": "lengths of guy lines: only the line between anchor and nozzle stretches here",
}
OF_M669 = {
    "P": "radius of the region that the firmware permits",
    "S": "segments of moves: ours are not divided",
    "T": "segments of moves: ours are not divided",
}
OTHER = {
    "M92": "steps per mm: drives that follow lengths exactly have no steps",
    "M98": "calls another file, which is not read: import it if it contains M669 or M666",
    "M201": "accelerations: set them in the motion of a scenario",
    "M203": "speeds: set them in the motion of a scenario",
    "M208": "limits of axes: cdpr has none",
    "M350": "microsteps: drives that follow lengths exactly have no steps",
    "M501": "loads config-override.g, which is not read: import it if it contains M669 or M666",
    "M566": "jerk of the firmware: set limits in the motion of a scenario",
    "M569": "directions of drives",
    "M584": "numbers of drives",
}


def recognise(content: bytes) -> bool:
    """Return True if a line sets the kinematics."""
    return re.search(rb"(?mi)^(?:\xef\xbb\xbf)?[ \t]*(?:N\d+[ \t]*)?M669\b", content) is not None


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a robot is read from this file."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        FormatError: if the file is invalid or not that of a Hangprinter.
    """
    commands = commands_of(content, str(path))
    commands.codes = KINEMATICS
    name = slug(path.stem if path.stem.lower() != "config" else "hangprinter", "hangprinter")
    found = Imported(name, f"RepRapFirmware: {path.name}", {"name": name}, [commands])
    values = _Values(str(path), commands)
    complete(found, values.printer(), str(path), choice.tension)
    if values.spring is not None:
        found.comments["cable", "axial_stiffness"] += ", as in its flex compensation without guy lines"
    if values.defaults:
        found.warnings.append(
            f"{path}: assumed the defaults of the firmware for a Hangprinter 4, because the file does not define them: "
            f"M666 {', '.join(values.defaults)}; other versions of the firmware have other defaults"
        )
    found.left_out += values.left_out + _others(commands)
    return found


@dataclass
class _Values:
    """Last value of each letter of M669 and M666."""

    file: str
    commands: Commands
    left_out: list[str] = field(default_factory=list)
    anchors: dict[str, Command] = field(default_factory=dict)
    spools: dict[str, Command] = field(default_factory=dict)
    count: int = DEFAULT_ANCHORS
    spring: Command | None = None
    defaults: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Sort the words of all commands."""
        every = [each for each in self.commands.every if each.code in KINEMATICS]
        for command in every:
            if command.inside:
                raise refuse(self.file, command.line, f"{command.code}: it is inside a condition or loop, which are "
                             "not computed: import a file without it")  # fmt: skip
        self._kinematics([each for each in every if each.code == "M669"])
        for command in every:
            for letter in command.words:
                self._sort(command, letter)
        self.spring = self.spools.get(STIFFNESS)

    def _kinematics(self, commands: list[Command]) -> None:
        """Check the type of kinematics; read the number of anchors."""
        types = [each for each in commands if "K" in each.words and ":" not in each.words["K"]]
        for command in types:
            (kind,) = command.numbers("K")
            if kind != HANGPRINTER:
                raise command.wrong("K", f"expected 6, a Hangprinter, got {kind:g}: other kinematics have no cables")
        if not types and not any(letter in each.words for each in commands for letter in "ABC"):
            raise refuse(self.file, commands[0].line, "M669: expected K6, a Hangprinter, and its anchors")
        for command in commands:
            if "N" in command.words:
                (count, *more) = command.numbers("N")
                if more or count not in range(FEWEST, len(LETTERS) + 1):
                    raise command.wrong("N", f"expected {FEWEST} to {len(LETTERS)} anchors, got {command.words['N']}")
                self.count = int(count)

    def _sort(self, command: Command, letter: str) -> None:
        if letter in command.read:
            return
        if command.code == "M669" and letter in LETTERS[: self.count]:
            self.anchors[letter] = command
        elif command.code == "M669" and letter in OF_M669:
            self._leave(command, letter, OF_M669[letter])
        elif command.code == "M669" and letter in LETTERS and command.words[letter].count(":") == 2:
            self._leave(command, letter, f"anchor {letter}: N is {self.count}, so that the firmware does not use it")
        elif command.code == "M669" and letter == MASS:
            self._leave(command, letter, "lengths of the mounted lines")
        elif (command.code == "M669" and letter in OLDER) or command.code == "M666":
            if command.code == "M666" and {"X", "Y", "Z"} <= command.words.keys():
                self._leave(command, letter, "adjustment of an end stop")
            elif letter in NOT_IMPORTED:
                self._leave(command, letter, NOT_IMPORTED[letter])
            else:
                self.spools[letter] = command

    def _leave(self, command: Command, letter: str, why: str) -> None:
        command.read.add(letter)
        self.left_out.append(f"{self.file}:{command.line}: {command.code} {letter}: {why}")

    def printer(self) -> Printer:
        """Return the numbers of the file."""
        lines = [self._line(letter) for letter in LETTERS[: self.count]]
        at = self._wind(lines)
        return Printer(
            lines,
            at,
            mass=self._one(MASS),
            stiffness=self._one(STIFFNESS),
            low=self._each(LOW, least=0.0),
            high=self._each(HIGH),
        )

    def _wind(self, lines: list[Line]) -> str:
        """Add the spools to the lines; return their source."""
        count = len(lines)
        radii = self._each(RADIUS) or self._default(RADIUS, [DEFAULT_RADIUS] * count)
        advantage = self._each(ADVANTAGE, least=1.0) or self._default(
            ADVANTAGE, [*[DEFAULT_ADVANTAGE] * (count - 1), DEFAULT_LAST_ADVANTAGE]
        )
        each, growth = self._each(LINES, least=1.0), self._one(GROWTH)
        if GROWTH not in self.spools:
            (value,), source = self._default(GROWTH, [DEFAULT_GROWTH])
            growth = value, source
        spools = self._each(SPOOL_TEETH) or self._default(SPOOL_TEETH, [DEFAULT_SPOOL_TEETH] * count)
        own = MOTOR_TEETH if MOTOR_TEETH in self.spools else OLD_MOTOR_TEETH
        motors = self._each(own) or self._default(MOTOR_TEETH, [DEFAULT_MOTOR_TEETH] * count)
        at = [f"drum_radius: {radii[1]}"]
        for line, radius in zip(lines, radii[0], strict=True):
            line.radius = round(radius * MM, 9)
        if growth is not None:
            at.append(f"drum_growth: {growth[1]}")
            for line in lines:
                line.transmission["drum_growth"] = round(growth[0] * MM, 12)
        for key, found in (("lines", each), ("reeving", advantage)):
            if found is not None:
                at.append(f"{key}: {found[1]}")
                for line, value in zip(lines, found[0], strict=True):
                    line.transmission[key] = value
        at.append(f"gear_ratio: {spools[1]}, over {motors[1]}")
        for line, spool, motor in zip(lines, spools[0], motors[0], strict=True):
            line.transmission["gear_ratio"] = spool / motor
        return "; ".join(at)

    def _default(self, letter: str, values: list[float]) -> tuple[list[float], str]:
        """Return values of the firmware, which a warning then lists, and their source."""
        self.defaults.append(f"{letter} {':'.join(f'{value:g}' for value in values)}")
        return values, DEFAULT

    def _line(self, letter: str) -> Line:
        command = self.anchors.get(letter)
        if command is None:
            raise refuse(
                self.file,
                next(each.line for each in self.commands.every if each.code == "M669"),
                f"M669: anchor {letter} is missing: expected {letter}X:Y:Z, mm, as N is {self.count}",
            )
        values = command.numbers(letter)
        if letter == "D" and len(values) == 1:  # older versions: above the origin
            values = [0.0, 0.0, *values]
        if len(values) != 3:
            raise command.wrong(letter, f"expected X:Y:Z, mm, got {command.words[letter]}")
        return Line(letter, [round(value * MM, 9) + 0.0 for value in values], command.at(letter))

    def _one(self, letter: str) -> tuple[float, str] | None:
        """Return a single value and its source; None if it is missing or 0, which the firmware does not use."""
        command = self.spools.get(letter)
        if command is None:
            return None
        (value, *more) = command.numbers(letter)
        if more or value < 0.0:
            raise command.wrong(letter, f"expected one number of at least 0, got {command.words[letter]}")
        return (value, command.at(letter)) if value else None

    def _each(self, letter: str, least: float | None = None) -> tuple[list[float], str] | None:
        """Return a value per line and their source; None if missing. They are above 0, or at least `least`."""
        command = self.spools.get(letter)
        if command is None:
            return None
        values = command.numbers(letter)
        text = command.words[letter]
        if len(values) != self.count:
            raise command.wrong(letter, f"expected {self.count} values, one per anchor, got {text}")
        if any(value < least if least is not None else value <= 0.0 for value in values):
            raise command.wrong(
                letter, f"expected values {'above 0' if least is None else f'from {least:g}'}, got {text}"
            )
        return values, command.at(letter)


def _others(commands: Commands) -> list[str]:
    """Return one line per other command that concerns motion, and one for the rest."""
    first: dict[str, Command] = {}
    for command in commands.every:
        first.setdefault(command.code, command)
    left_out = [f"{each.file}:{each.line}: {code}: {OTHER[code]}" for code, each in first.items() if code in OTHER]
    rest = [code for code in first if code not in OTHER and code not in KINEMATICS]
    if rest:
        shown = ", ".join(rest[:12]) + (", ..." if len(rest) > 12 else "")
        left_out.append(f"{commands.file}: commands that concern neither anchors nor lines: {shown}")
    return left_out
