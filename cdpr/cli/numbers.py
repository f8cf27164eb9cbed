"""Numbers as they are typed: Python would take 4_0 for 40, and the digits of other scripts, which files do not."""

from __future__ import annotations

from typing import Any

import click


def number(text: str) -> float:
    """Return the number; ValueError where the text is none."""
    if not plain(text):
        raise ValueError(f"a number is expected, got {text[:80]!r}")
    return float(text)


def plain(text: str) -> bool:
    """Whether a text may be a number of ours."""
    return text.isascii() and "_" not in text


class _Plain(click.ParamType[Any]):
    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        if isinstance(value, str) and not plain(value):
            self.fail(f"a number is expected, got {value[:80]!r}", param, ctx)
        return super().convert(value, param, ctx)


class AnyWhole(_Plain, click.types.IntParamType):
    """A whole number."""


class AnyReal(_Plain, click.types.FloatParamType):
    """A number."""


class Whole(_Plain, click.IntRange):
    """A whole number within bounds."""


class Real(_Plain, click.FloatRange):
    """A number within bounds."""
