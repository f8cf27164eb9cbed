"""Lists of names in options."""

from __future__ import annotations


def names(text: str) -> list[str]:
    """Names separated by commas."""
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
