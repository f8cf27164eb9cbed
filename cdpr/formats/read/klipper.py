"""Reader of Klipper configurations with winches: `[printer] kinematics: winch` in `printer.cfg`.

Each section `[stepper_a]`, `[stepper_b]`, ... is a line, up to the first letter that is missing: its anchor in mm, and
`rotation_distance`, mm of line per turn of the drum. Values that Klipper saved at the end of the file (`#*#`) replace
the others.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from string import ascii_lowercase

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.base.problems import short_repr
from cdpr.formats.read.hangprinter import MM, Line, Printer, complete
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, refuse, slug
from cdpr.formats.read.text_lines import lines_of
from cdpr.formats.read.unread import Unread

FEWEST = 3  # steppers that Klipper requires
PRINTER = "printer"
SAVED = "#*#"
STEPS = "drives that follow lengths exactly have no steps"
NOT_IMPORTED = {
    "step_pin": "pin of the board",
    "dir_pin": "pin of the board",
    "enable_pin": "pin of the board",
    "microsteps": STEPS,
    "full_steps_per_rotation": STEPS,
    "step_pulse_duration": STEPS,
    "max_velocity": "set limits in the motion of a scenario",
    "max_accel": "set limits in the motion of a scenario",
}


def recognise(content: bytes) -> bool:
    """Return True if the kinematics of the printer are winches."""
    return re.search(rb"(?m)^(?:#\*#[ \t]*)?kinematics[ \t]*[:=][ \t]*winch[ \t]*(?:[#;\r]|$)", content) is not None


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a robot is read from this file."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        FormatError: if the file is invalid.
    """
    sections = _sections(content, str(path))
    name = slug(path.stem if path.stem.lower() != PRINTER else "winch_printer", "winch_printer")
    found = Imported(name, f"Klipper: {path.name}", {"name": name}, [sections])
    if PRINTER in sections.every:
        sections.every[PRINTER].read.add("kinematics")
    letters = [letter for letter in ascii_lowercase if f"stepper_{letter}" in sections.every]
    used = ascii_lowercase[: next(k for k, each in enumerate([*letters, ""]) if each != ascii_lowercase[k])]
    if len(used) < FEWEST:
        missing = f"stepper_{ascii_lowercase[len(used)]}"
        raise FormatError(f"{path}: section [{missing}] is missing: kinematics 'winch' need three or more steppers")
    complete(found, _printer(sections, used), str(path), choice.tension)
    found.left_out += _left_out(sections, used)
    return found


@dataclass
class _Section:
    """Section with the value and line of each key."""

    file: str
    name: str
    line: int
    values: dict[str, tuple[str, int]] = field(default_factory=dict)
    read: set[str] = field(default_factory=set)

    def number(self, key: str) -> float:
        """Return a finite number.

        Raises:
            FormatError: if it is missing or not one.
        """
        self.read.add(key)
        if key not in self.values:
            raise refuse(self.file, self.line, f"[{self.name}]: {key} is missing: expected a number, mm")
        text, line = self.values[key]
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not abs(value) <= MAX_MAGNITUDE:
            wanted = f"expected a number of at most {MAX_MAGNITUDE:g}, mm"
            raise refuse(self.file, line, f"[{self.name}] {key}: {wanted}, got {short_repr(text)}")
        return value


@dataclass
class _Sections:
    file: str
    every: dict[str, _Section] = field(default_factory=dict)
    includes: list[int] = field(default_factory=list)

    def unread(self) -> Iterator[Unread]:
        """Yield the keys of read sections that were not read."""
        for section in self.every.values():
            for key, (_, line) in section.values.items() if section.read else ():
                if key not in section.read:
                    yield Unread(self.file, line, f"key '{key}'")


def _sections(content: bytes, file: str) -> _Sections:
    """Return the sections of a file.

    Raises:
        FormatError: if a line is neither a section, a key nor a continuation, or the file is too long.
    """
    found = _Sections(file)
    section: _Section | None = None
    for number, line in enumerate(lines_of(content, file), 1):
        saved = line.startswith(SAVED)
        text = re.split(r"#|\s;|^;", line.removeprefix(SAVED).removeprefix(" ") if saved else line, maxsplit=1)[0]
        if not text.strip() or set(text.strip()) <= set("-<> ") or (saved and "SAVE_CONFIG" in text):
            continue
        if (head := re.match(r"\[\s*([^\]]+?)\s*\]", text)) is not None:
            section = found.every.setdefault(head[1], _Section(file, head[1], number))
            if head[1].startswith("include "):
                found.includes.append(number)
        elif text[0].isspace():
            continue  # continuation of a value, such as a macro
        elif (pair := re.match(r"([^:=]+?)\s*[:=]\s*(.*?)\s*$", text)) is not None and section is not None:
            section.values[pair[1].lower()] = pair[2], number
        elif not saved:
            raise refuse(file, number, f"expected [section] or KEY: VALUE, got {short_repr(text.strip())}")
    return found


def _printer(sections: _Sections, used: str) -> Printer:
    """Return the lines of the steppers."""
    lines = []
    for letter in used:
        section = sections.every[f"stepper_{letter}"]
        anchor = [round(section.number(f"anchor_{axis}") * MM, 9) + 0.0 for axis in "xyz"]
        travel = section.number("rotation_distance")
        if travel <= 0.0:
            line = section.values["rotation_distance"][1]
            text = f"[{section.name}] rotation_distance: expected a number above 0, mm, got {travel:g}"
            raise refuse(sections.file, line, text)
        at = f"[{section.name}], line {section.line}"
        lines.append(Line(letter.upper(), anchor, at, travel * MM / (2.0 * math.pi), _gear(section)))
    return Printer(lines, "drum_radius: rotation_distance / (2 pi)")


def _gear(section: _Section) -> dict[str, float]:
    """Return the turns of the motor per turn of the drum, from pairs such as `57:11, 2:1`.

    Raises:
        FormatError: if they are not pairs of positive numbers.
    """
    section.read.add("gear_ratio")
    text, line = section.values.get("gear_ratio", ("", 0))
    ratio = 1.0
    for pair in text.split(",") if text else ():
        try:
            motor, drum = (float(part) for part in pair.split(":"))
        except ValueError:
            motor = drum = 0.0
        if not (0.0 < motor <= MAX_MAGNITUDE and 0.0 < drum <= MAX_MAGNITUDE):
            wanted = "expected pairs such as 57:11, 2:1"
            raise refuse(section.file, line, f"[{section.name}] gear_ratio: {wanted}, got {short_repr(text)}")
        ratio *= motor / drum
    return {"gear_ratio": ratio} if text else {}


def _left_out(sections: _Sections, used: str) -> list[str]:
    """Return what is not imported: keys with a known reason once, sections of unused steppers, includes."""
    left_out = list[str]()
    reported = set[str]()
    for name, section in sections.every.items():
        stepper = re.fullmatch(r"stepper_([a-z])", name)
        if stepper is not None and stepper[1] not in used:
            left_out.append(f"{sections.file}:{section.line}: [{name}]: Klipper does not use it, for "
                        f"[stepper_{ascii_lowercase[len(used)]}] is missing")  # fmt: skip
        for key, (_, line) in section.values.items() if name == PRINTER or stepper is not None else ():
            if key in NOT_IMPORTED:
                section.read.add(key)
                if key not in reported:
                    left_out.append(f"{sections.file}:{line}: {key}: {NOT_IMPORTED[key]}")
                reported.add(key)
    left_out += [f"{sections.file}:{line}: [include]: this other file is not read" for line in sections.includes]
    rest = [
        name
        for name in sections.every
        if name != PRINTER and not name.startswith(("include ", "stepper_")) and name != "DEFAULT"
    ]
    if rest:
        shown = ", ".join(short_repr(name) for name in rest[:12]) + (", ..." if len(rest) > 12 else "")
        left_out.append(f"{sections.file}: sections that concern neither anchors nor lines: {shown}")
    return left_out
