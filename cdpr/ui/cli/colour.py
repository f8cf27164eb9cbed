"""Colours of the command line, only on terminals.

Colours are added when text is written, after all control characters were escaped: no text from a file can switch them.
"""

from __future__ import annotations

import os
import re
from functools import cache
from typing import TextIO

RESET = "\x1b[0m"
BOLD, DIM, RED, GREEN, YELLOW, CYAN = "\x1b[1m", "\x1b[2m", "\x1b[31m", "\x1b[32m", "\x1b[33m", "\x1b[36m"

FULL, EMPTY = "━", "─"  # of a progress bar

# Colour rules of a line; at each position the first matching rule applies.
RULES = (
    (r"^(?:internal error|Error):.*", RED),
    (r"^[^\s:]+:\d+(?::\d+)?:(?= )", RED),  # file and line of an error
    (r"^warning: ", YELLOW),
    (r"^[A-Z][A-Za-z ]*:$|^Usage:", BOLD),
    (rf"{FULL}+", GREEN),
    (rf"{EMPTY}+", DIM),
    (r"(?:(?<=, )|(?<=: )|(?<=\d )|^)(?:finished|agrees?|balanced|ok)\b(?=$|[:;,( ])", GREEN),
    (r"(?:(?<=, )|(?<=: )|(?<=\d )|^)(?:DISAGREES?|diverged|infeasible|failed|FAILED|died|hung)\b(?=$|[:;,( ])", RED),
    (r"(?:(?<=, )|(?<=: )|^)(?:not judged|interrupted|not installed)\b(?=$|[:;,( ])", YELLOW),
    (r"^  (?! )\S[^\n]*?(?=  +\S)", CYAN),  # first column of a list
)


def wanted(stream: TextIO) -> bool:
    """Return True if the stream supports colours and the user wants them (https://no-color.org)."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    if os.name == "nt" and "WT_SESSION" not in os.environ:
        return False
    try:
        return stream.isatty()
    except (AttributeError, ValueError):  # closed, or not a system stream
        return False


@cache
def _any_rule() -> re.Pattern[str]:
    """Return the union of `RULES`, compiled on first use because most output has no colours."""
    return re.compile("|".join(f"(?P<r{k}>{rule})" for k, (rule, _) in enumerate(RULES)), re.MULTILINE)


def coloured(text: str) -> str:
    """Return printable text with the colours of `RULES`."""
    return _any_rule().sub(lambda found: f"{RULES[int(str(found.lastgroup)[1:])][1]}{found[0]}{RESET}", text)


def bar(share: float, encoding: str | None, width: int = 24) -> str:
    """Return a progress bar filled by `share` (0 to 1), in characters of the encoding."""
    filled, empty = (FULL, EMPTY) if "utf" in (encoding or "").lower() else ("#", "-")
    full = round(width * min(max(share, 0.0), 1.0))
    return filled * full + empty * (width - full)
