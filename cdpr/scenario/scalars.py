"""What an unquoted word of YAML means: the core schema of YAML 1.2, in its strictest reading.

PyYAML follows YAML 1.1, where `no` is false, `010` is 8, `1:30` is 90 and `1e-3` is a text. Here only `true`,
`false`, `null`, `~`, decimal integers and decimal floats mean anything; whatever else looks like a number is
a text, so that the models refuse it instead of computing with a number that nobody wrote.
"""

from __future__ import annotations

import re

INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|(?:0|[1-9][0-9]*)(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
SPECIAL = {
    ".inf": "inf",
    "+.inf": "inf",
    "-.inf": "-inf",
    ".nan": "nan",
}  # the models refuse them as not finite
WORDS: dict[str, bool | None] = {"true": True, "false": False, "null": None, "~": None, "": None}

MAX_DIGITS = 308  # beyond this an integer is no float; Python itself refuses beyond 4300


def resolve(text: str) -> str | int | float | bool | None:
    """Return the value of an unquoted scalar; ValueError for an integer too long to be a number."""
    if text in WORDS:
        return WORDS[text]
    if text.lower() in SPECIAL:
        return float(SPECIAL[text.lower()])
    if INTEGER.fullmatch(text):
        if len(text) > MAX_DIGITS:
            raise ValueError(f"a whole number of {len(text)} digits is too large")
        return int(text)
    return float(text) if FLOAT.fullmatch(text) else text
