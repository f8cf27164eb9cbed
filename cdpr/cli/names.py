"""What options of several commands share: lists of names, and files with plugins."""

from __future__ import annotations

from functools import partial
from typing import Any

import click


def names(text: str) -> list[str]:
    """Names separated by commas."""
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def plugin_files(command: Any) -> Any:
    """Give a command the option --plugin: its files are in use until the command ends."""

    def use(context: click.Context, parameter: click.Parameter, files: tuple[str, ...]) -> None:
        if files and not context.resilient_parsing:
            from cdpr.plugins import registry

            context.call_on_close(partial(registry.use_files, registry.plugin_files()))
            registry.use_files(files)

    text = "Python file with backends, controllers or solvers of your own; repeatable."
    return click.option("--plugin", metavar="FILE", multiple=True, expose_value=False, callback=use, help=text)(command)
