"""Lines of a text file, with limits on their number and length."""

from __future__ import annotations

from cdpr.base.errors import FormatError
from cdpr.formats.read.imported import refuse

MAX_LINES = 200_000
MAX_LENGTH = 2_000  # characters; the time of some expressions grows with its square


def lines_of(content: bytes, file: str) -> list[str]:
    """Return the lines of a file in ASCII or an extension of it; other characters keep their number, not meaning.

    Raises:
        FormatError: if it has too many lines, or one that is too long.
    """
    # Of bytes: latin-1 text would also end a line at the byte 0x85, which is part of some UTF-8 letters.
    lines = [each.decode("latin-1") for each in content.removeprefix(b"\xef\xbb\xbf").splitlines()]
    if len(lines) > MAX_LINES:
        raise FormatError(f"{file}: expected at most {MAX_LINES} lines, got {len(lines)}")
    for number, line in enumerate(lines, 1):
        if len(line) > MAX_LENGTH:
            raise refuse(file, number, f"expected lines of at most {MAX_LENGTH} characters, got {len(line)}")
    return lines
