"""Numbers as typed on the command line: Python accepts 4_0 as 40 and digits of other scripts; files do not."""

from __future__ import annotations

from typing import Any

import click


def number(text: str) -> float:
    """Return the number.

    Raises:
        ValueError: if the text is no number.
    """
    if not is_plain(text):
        raise ValueError(f"expected a number, got {text[:80]!r}")
    return float(text)


def is_plain(text: str) -> bool:
    """Return True if a text has only characters allowed in numbers."""
    return text.isascii() and "_" not in text


class _Plain(click.ParamType[Any]):
    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        if isinstance(value, str) and not is_plain(value):
            self.fail(f"expected a number, got {value[:80]!r}", param, ctx)
        return super().convert(value, param, ctx)


class AnyWhole(_Plain, click.types.IntParamType):
    """Whole number."""


class AnyReal(_Plain, click.types.FloatParamType):
    """Number."""


class Whole(_Plain, click.IntRange):
    """Whole number within bounds."""


class Real(_Plain, click.FloatRange):
    """Number within bounds."""
