"""Interpretation of unquoted YAML scalars: a strict form of the YAML 1.2 core schema.

PyYAML follows YAML 1.1, in which `no` is false, `010` is 8, `1:30` is 90 and `1e-3` is a text. Here only `true`,
`false`, `null`, `~`, decimal integers and decimal floats are special. Everything else is a text, so that the models
reject it instead of computing with an unintended number.
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
}  # rejected later as not finite
WORDS: dict[str, bool | None] = {"true": True, "false": False, "null": None, "~": None, "": None}

MAX_DIGITS = 308  # larger integers overflow floats; Python itself rejects more than 4300 digits


def resolve(text: str) -> str | int | float | bool | None:
    """Return the value of an unquoted scalar; raise ValueError if an integer is too long."""
    if text in WORDS:
        return WORDS[text]
    if text.lower() in SPECIAL:
        return float(SPECIAL[text.lower()])
    if INTEGER.fullmatch(text):
        if len(text) > MAX_DIGITS:
            raise ValueError(f"a whole number of {len(text)} digits is too large")
        return int(text)
    return float(text) if FLOAT.fullmatch(text) else text
