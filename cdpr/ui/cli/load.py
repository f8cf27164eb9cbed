"""Loading of scenario and robot files by commands; warnings are printed on stderr or treated as errors."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from cdpr.base.problems import Problem
    from cdpr.model import Robot
    from cdpr.scenario import Scenario

strict_option = click.option("--strict", is_flag=True, help="Turn warnings into errors, with exit code 2.")


def load_with_warnings(file: str, changes: tuple[str, ...], *, strict: bool = False) -> Scenario | Robot:
    """Load and check a file, and print its notes and warnings.

    Raises:
        ScenarioError: if the file is invalid, or has warnings and `strict` is set.
    """
    from cdpr.config.problems import judged
    from cdpr.scenario import load_any

    notes: list[str] = []
    warnings: list[Problem] = []
    loaded = load_any(file, overrides=changes, notes=notes, warnings=warnings)
    print_lines([*notes, *judged(warnings, strict=strict)])
    return loaded


def print_lines(lines: Iterable[str]) -> None:
    """Print lines on stderr."""
    for line in lines:
        click.echo(line, err=True)
