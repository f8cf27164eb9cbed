"""Translation of command-line options in messages into the names of GUI fields."""

from __future__ import annotations

import re

# Patterns as in messages, and labels of the dialogs in page/exchange.js and page/files.js.
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
)


def in_window(text: str) -> str:
    """Return a message with GUI fields in place of command-line options."""
    for option, field in FIELDS:
        text = re.sub(option, field, text)
    return text
