"""Colours by name."""

from __future__ import annotations

import re

# Basic colours of CSS and their "#rrggbb" values.
COLOURS = {
    "black": "#000000",
    "silver": "#c0c0c0",
    "grey": "#808080",
    "white": "#ffffff",
    "red": "#ff0000",
    "orange": "#ffa500",
    "yellow": "#ffff00",
    "green": "#008000",
    "blue": "#0000ff",
    "purple": "#800080",
}


def coloured(value: str) -> str:
    """Return a colour as "#rrggbb"; raise ValueError unless it is one or the name of one."""
    known = COLOURS.get(value, value.lower())
    if not re.fullmatch(r"#[0-9a-f]{6}", known):
        raise ValueError(f"expected a colour, '#rrggbb' or one of {', '.join(COLOURS)}, got {value[:20]!r}")
    return known
