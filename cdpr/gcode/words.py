"""G-code parser: lines of words (letter and number) in the dialects of LinuxCNC and RepRapFirmware.

Both descend from RS-274 (NIST, Kramer, Proctor and Messina 2000). LinuxCNC ignores spaces within a line. For
RepRapFirmware, the rest of a line after an M word belongs to it and may be any text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from cdpr.base.files import MAX_FAULTS, ContentError, UnreadableError, text_of
from cdpr.base.problems import shown

LINUXCNC, REPRAPFIRMWARE = "linuxcnc", "reprapfirmware"

MAX_BYTES = 32 * 1024 * 1024
MAX_LINE = 1000  # characters; controllers accept 256
EACH = 1000  # lines, or steps, between two checks of the CPU time
DIVIDE = "divide the file"  # remedy for a program that takes too long

WORD = re.compile(r"([A-Z])\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)|)\s*")
WORDS = re.compile(rf"(?:{WORD.pattern})*")
COMMENT = re.compile(r"\([^()]*\)")
QUOTED = re.compile(r'"[^"]*"?')
# Directly after a digit, RepRapFirmware reads E as an exponent, others as filament.
EXPONENT = re.compile(r"[A-Z]?\s*[-+0-9.]*[0-9.]E[-+]?[0-9]+")
# M words with unquoted text: file names, messages.
TEXTS = {23.0, 28.0, 30.0, 32.0, 36.0, 37.0, 38.0, 98.0, 117.0, 118.0}
COMPUTED = re.compile(r"(IF|ELIF|ELSE|WHILE|BREAK|CONTINUE|VAR|GLOBAL|SET|ABORT)\b")
SAID = re.compile(r"ECHO\b")
# Named command, as of Klipper's firmware and slicers for it: EXCLUDE_OBJECT_START NAME=a.
COMMAND = "[A-Z_]{3,}[A-Z0-9_]*"
LEADING_COMMAND = re.compile(rf"({COMMAND})(?=\s|$)")
# Program number, alone on its line: O0001, or :0001 in ISO code.
PROGRAM_NUMBER = re.compile(r"(?:N[0-9]+)?[O:]([0-9]+)")


class Word(NamedTuple):
    """Letter with its number (None if missing), or named command without number."""

    letter: str
    value: float | None

    @property
    def name(self) -> str:
        """The word as written: G1, M104, X-2.5."""
        return self.letter if self.value is None else f"{self.letter}{self.value:g}"


class LineError(Exception):
    """Error in a line."""


def read_lines(
    content: bytes, dialect: str, check: Callable[[], None] = lambda: None
) -> Iterator[tuple[int, list[Word] | LineError]]:
    """Yield the number and the words of each non-empty line, or its error.

    `check` is called every EACH lines.

    Raises:
        ContentError: if the content is not text, or `check` raises UnreadableError.
    """
    text = text_of(content, MAX_BYTES)
    if "\0" in text:
        raise ContentError([(text.count("\n", 0, text.index("\0")) + 1, 0, "this is not a text: it has a zero byte")])
    percent, faults = 0, 0
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    for number, row in enumerate(text.split("\n"), 1):
        if number % EACH == 0:
            checked(check, number)
        if row.strip() == "%":
            percent += 1
            if percent == 2:
                return
            continue
        try:
            words = _words(row, dialect)
        except LineError as fault:
            yield number, fault
            faults += 1
            if faults == MAX_FAULTS:
                return
            continue
        if words:
            yield number, words


def checked(check: Callable[[], None], line: int) -> None:
    """Call `check` and convert its UnreadableError into a ContentError for a line."""
    try:
        check()
    except UnreadableError as error:
        raise ContentError([(line, 0, str(error))]) from None


def _words(text: str, dialect: str) -> list[Word]:
    """Return the words of a line, without its line number."""
    line = text.partition(";")[0]
    command = LEADING_COMMAND.match(line.strip().upper())
    if command and (dialect == LINUXCNC or not (SAID.match(command[1]) or COMPUTED.match(command[1]))):
        return [Word(command[1], None)]
    if "(" in line:
        line = COMMENT.sub(" ", line)
    line = line.strip().upper()
    if not line:
        return []
    if len(line) > MAX_LINE:
        raise LineError(f"expected a line of at most {MAX_LINE} characters, got {len(line)}")
    if "(" in line or ")" in line:
        raise LineError("a comment in brackets must end in its line, and must not contain another")
    if line[0] == "/":
        raise LineError("lines that begin with '/' depend on a switch of the machine: remove the '/', or the line")
    if dialect == LINUXCNC:
        _plain_numbers(line)
        line = line.replace(" ", "").replace("\t", "")
        program = PROGRAM_NUMBER.fullmatch(line)
        if program:
            return [Word("O", float(program[1]))]
        if line[0] == "O" or "#" in line or "[" in line:
            raise LineError("parameters, expressions and O words are not supported: write their values")
        return _split(line)
    star = line.rfind("*")
    if star >= 0:
        _check_sum(text.partition(";")[0], line[star + 1 :])
        line = line[:star].rstrip()
    if SAID.match(line):
        return [Word("M", 118.0)]  # also a message
    if COMPUTED.match(line) or "{" in line:
        raise LineError("conditions, loops, variables and expressions are not supported: write their values")
    begin = re.match(r"N\s*[0-9]+\s*", line)
    line = line[begin.end() :] if begin else line
    # The text after M or T belongs to it.
    free = re.search(r"[MT](?=\s*[-0-9])", line)
    _plain_numbers(line if free is None else line[: free.start()])
    if free is None:
        return _split(line)
    command = WORD.match(line, free.start())
    assert command is not None
    if command[1] == "T" or float(command[2]) not in TEXTS:
        other = re.search(r"[GM]\s*[0-9]+", QUOTED.sub("", line[command.end() :]))
        if other:
            raise LineError(f"{other[0]} is another command behind {command[1]}{command[2]}: put it on a separate line")
    own = WORD.match(line, command.end())
    words = [*_split(line[: free.start()]), Word(command[1], float(command[2]))]
    return [*words, _word(own)] if own and own[1] == "S" and own[2] else words


def _plain_numbers(line: str) -> None:
    found = EXPONENT.search(line)
    if found:
        raise LineError(
            f"{shown(found[0])}: E behind a digit is an exponent to some, filament to others: write out the number, "
            "or a space before the E"
        )


def _split(line: str) -> list[Word]:
    whole = WORDS.match(line)
    assert whole is not None  # the pattern matches an empty text
    if whole.end() < len(line):
        place = line[whole.end() : whole.end() + 20]
        raise LineError(f"expected words of a letter and a number, got {shown(place)}")
    return [Word(name, float(number) if number else None) for name, number in WORD.findall(line) if name != "N"]


def _word(match: re.Match[str]) -> Word:
    return Word(match[1], float(match[2]) if match[2] else None)


def _check_sum(text: str, given: str) -> None:
    """Compare the exclusive or of the text before the last '*', excluding comments, with the given checksum."""
    star = COMMENT.sub(lambda comment: " " * len(comment[0]), text).rfind("*")
    found = 0
    for byte in text[:star].lstrip().encode():
        found ^= byte
    if not given.strip().isdigit() or int(given) != found:
        raise LineError(f"the line was changed: its checksum is {found}, {shown(given.strip())} is written there")
