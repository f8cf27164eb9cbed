"""What messages call an option of a command is a field of the window."""

from __future__ import annotations

import re

# As messages have them, and the labels of the dialogs: page/exchange.js and page/files.js.
FIELDS = (
    (r"\(--cable-set\)", "(the field Cable set)"),
    (r"\(--trajectory\)", "(the field Trajectory)"),
    (r"\(--tension\b[^()]*\)", "(the fields Tension limits)"),
    (r"\(--seconds\b[^()]*\)", "(the field CPU time)"),
    (r"\(--crossed\)", "(the field Cables at the platform)"),
    (r"\(--straight\)", "(the field Cables at the platform)"),
    (r"\(--suspended\)", "(the field Suspended)"),
    (r"\(--planar\)", "(the field Planar)"),
    (r"\(--pulleys-as-points\)", "(the field Pulleys)"),
    (r"\(--set\b[^()]*\)", "(in the form)"),
    (r"\banother --out\b", "another place"),
)


def in_window(text: str) -> str:
    """Return a message with the fields that a window has in place of options."""
    for option, field in FIELDS:
        text = re.sub(option, field, text)
    return text
