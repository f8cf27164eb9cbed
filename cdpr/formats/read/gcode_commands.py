"""Commands of a firmware's G-code configuration, with their lines and parameters."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.base.problems import short_repr
from cdpr.formats.read.imported import refuse
from cdpr.formats.read.text_lines import lines_of
from cdpr.formats.read.unread import Unread

# A letter and its value: a text in quotes, an expression in braces, or anything up to the next letter or space.
WORD = re.compile(r"""([A-Z])\s*("(?:[^"]|"")*"|\{[^}]*\}|[-+]?[0-9.:+\-]*(?:E[-+]?[0-9]+)?)""")
COMMAND = re.compile(r"(?:N\d+\s*)?([GMT])\s*(\d+(?:\.\d+)?)")
META = re.compile(r"(?:if|elif|else|while|break|continue|var|global|set|echo|abort)\b")


@dataclass
class Command:
    """Command and its parameters.

    Attributes:
        file: name of the file.
        line: its line.
        code: such as "M669".
        words: value of each parameter, as text, by letter.
        inside: True if it is indented below a condition or a loop.
        read: letters that were read or reported.
    """

    file: str
    line: int
    code: str
    words: dict[str, str]
    inside: bool = False
    read: set[str] = field(default_factory=set)

    def at(self, letter: str) -> str:
        """Return the source of a parameter, for comments."""
        return f"{self.code} {letter}, line {self.line}"

    def numbers(self, letter: str) -> list[float]:
        """Return the values of a parameter, which a colon separates.

        Raises:
            FormatError: if they are not finite numbers.
        """
        self.read.add(letter)
        text = self.words[letter]
        if text[:1] == "{":
            raise self.wrong(letter, f"expressions are not computed: write the number instead of {short_repr(text)}")
        if not text:
            raise self.wrong(letter, f"expected a number after each letter, got {short_repr(self._unnumbered(letter))}")
        try:
            values = [float(part) for part in text.split(":")]
        except ValueError:
            values = [math.nan]
        if not all(abs(value) <= MAX_MAGNITUDE for value in values):
            raise self.wrong(letter, f"expected numbers of at most {MAX_MAGNITUDE:g}, got {short_repr(text)}")
        return values

    def _unnumbered(self, letter: str) -> str:
        """Return a parameter without a number and its neighbours up to the next number: letters of one word."""
        words = list(self.words.items())
        first = last = [name for name, _ in words].index(letter)
        while first and not words[first - 1][1]:
            first -= 1
        while last + 1 < len(words) and not words[last][1]:
            last += 1
        return "".join(name + value for name, value in words[first : last + 1])

    def wrong(self, letter: str, text: str) -> FormatError:
        """Return the error for a parameter."""
        return refuse(self.file, self.line, f"{self.code} {letter}: {text}".replace(" :", ":"))


@dataclass
class Commands:
    """All commands of a file.

    Attributes:
        file: name of the file.
        every: the commands in their order.
        codes: commands whose parameters are reported if they are not read.
    """

    file: str
    every: list[Command]
    codes: tuple[str, ...] = ()

    def unread(self) -> Iterator[Unread]:
        """Yield the parameters of `codes` that were not read."""
        for command in self.every:
            if command.code in self.codes:
                for letter in command.words:
                    if letter not in command.read:
                        yield Unread(self.file, command.line, f"{command.code} {letter}")


def commands_of(content: bytes, file: str) -> Commands:
    """Return the commands of a file; comments and other text are skipped.

    Raises:
        FormatError: if the file is too long.
    """
    every = list[Command]()
    block = -1  # indentation of the innermost condition or loop, -1 outside
    for number, line in enumerate(lines_of(content, file), 1):
        text = _without_comment(line)
        depth = len(text) - len(text.lstrip())
        text = text.strip()
        if not text:
            continue
        if depth <= block:
            block = -1
        if META.match(text):
            if text.startswith(("if", "elif", "else", "while")) and block < 0:
                block = depth
            continue
        every += _commands(text, file, number, block >= 0)
    return Commands(file, every)


def _without_comment(line: str) -> str:
    """Return a line up to its comment, which a text in quotes may not begin."""
    if '"' not in line:
        return re.sub(r"\([^)]*\)", " ", line.split(";", 1)[0])
    found = re.match(r'(?:[^";]|"(?:[^"]|"")*")*', line)
    return line if found is None else found[0]


def _commands(text: str, file: str, line: int, inside: bool) -> Iterator[Command]:
    """Yield the commands of a line; a second one begins with G or M and a number."""
    capital = re.sub(r'"(?:[^"]|"")*"|\{[^}]*\}|[a-z]+', lambda part: _capital(part[0]), text)
    first = COMMAND.match(capital)
    if first is None:
        return
    command = Command(file, line, f"{first[1]}{first[2]}", {}, inside)
    for word in WORD.finditer(capital, first.end()):
        if word[1] in "GM" and word[2].isdigit() and len(word[2]) > 0 and command.words.get(word[1]) is None:
            yield command
            command = Command(file, line, f"{word[1]}{word[2]}", {}, inside)
        else:
            command.words.setdefault(word[1], word[2])
    yield command


def _capital(part: str) -> str:
    return part if part[0] in '"{' else part.upper()
