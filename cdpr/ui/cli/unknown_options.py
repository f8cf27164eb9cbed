"""Hint for an unknown option that has the name of a key of scenarios."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence

import click

SHOWN = 3  # keys
DEPTH = 2  # names in a key; deeper keys are those of single parts, as are keys of items of lists


def with_hint(error: click.ClickException, arguments: Sequence[str]) -> click.ClickException:
    """Return the error with the `--set` that changes the key of this name; the same error if there is none.

    Args:
        error: any error of a command line.
        arguments: the command line without the program.
    """
    context = getattr(error, "ctx", None)
    if not isinstance(error, click.NoSuchOption) or context is None:
        return error
    if not any("--set" in parameter.opts for parameter in context.command.params):
        return error
    from cdpr.ui.cli.completion import scenario_keys

    name = error.option_name.lstrip("-").replace("-", "_")
    found = [key for key in scenario_keys() if _is_common(key, name)]
    if not found:
        return error
    value = _value(error.option_name, arguments)
    hints = " or ".join(f"--set {key}={value}" for key in found[:SHOWN])
    return click.UsageError(
        f"No such option {error.option_name!r}. To change this key of the scenario, use {hints}.", context
    )


def _is_common(key: str, name: str) -> bool:
    parts = key.split(".")
    return parts[-1] == name and len(parts) <= DEPTH and "[" not in key


def _value(option: str, arguments: Sequence[str]) -> str:
    """Return the value that was given to an option; VALUE without one."""
    for i, argument in enumerate(arguments):
        name, equals, value = argument.partition("=")
        if name == option:
            following = arguments[i + 1] if i + 1 < len(arguments) else ""
            if not equals and not re.match(r"--|-[A-Za-z]", following):
                value = following
            return shlex.quote(value) if value else "VALUE"
    return "VALUE"
