"""A scenario or robot file as commands load it: what is allowed but seldom meant is told on stderr, or refused."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from cdpr.model import Robot
    from cdpr.problems import Problem
    from cdpr.scenario import Scenario

strict_option = click.option(
    "--strict", is_flag=True, help="Refuse what is only warned of otherwise, with exit code 2."
)


def load_told(file: str, changes: tuple[str, ...], *, strict: bool = False) -> Scenario | Robot:
    """Load and check a file, and tell its notes and warnings; where `strict`, ScenarioError for any of the latter."""
    from cdpr.scenario import load_any
    from cdpr.scenario.problems import judged

    notes: list[str] = []
    warnings: list[Problem] = []
    loaded = load_any(file, overrides=changes, notes=notes, warnings=warnings)
    tell([*notes, *judged(warnings, strict=strict)])
    return loaded


def tell(lines: Iterable[str]) -> None:
    """Write on stderr."""
    for line in lines:
        click.echo(line, err=True)
