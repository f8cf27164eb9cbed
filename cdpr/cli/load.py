"""A scenario or robot file as commands load it: what is allowed but seldom meant is told on stderr."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from cdpr.model import Robot
    from cdpr.scenario import Scenario


def load_told(file: str, changes: tuple[str, ...]) -> Scenario | Robot:
    """Load and check a file, and tell its notes."""
    from cdpr.scenario import load_any

    notes: list[str] = []
    loaded = load_any(file, overrides=changes, notes=notes)
    for note in notes:
        click.echo(note, err=True)
    return loaded
