"""Options shared by several commands: lists of names, and files with plugins."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from cdpr.ui.cli.completion import keys, plugins

if TYPE_CHECKING:
    from cdpr.plugins.info import Role

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

PLUGIN_FILES = "cdpr.plugin_files"  # key of the --plugin files in a context


class OutPath(click.Path):
    """Output path; empty paths are rejected."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path; an empty one, as of an unset variable, would mean the working folder."""
        if not os.fspath(value):
            self.fail("expected a name, got an empty one; write . for this folder", param, ctx)
        return super().convert(value, param, ctx)


def again(context: click.Context, *more: str) -> str:
    """Return the text of the same command with `more` options, such as --out FOLDER, in place of its --out."""
    import shlex  # only for commands that refer to themselves

    return shlex.join([*context.command_path.split(), *_words(context), *more])


def _words(context: click.Context) -> Iterator[str]:
    """Yield the given arguments and options except --out."""
    for file in context.meta.get(PLUGIN_FILES, ()):
        yield from ("--plugin", file)
    for parameter in context.command.params:
        name, value = str(parameter.name), context.params.get(str(parameter.name))
        given = context.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if not given or name in ("out", "plugin") or value is None:
            continue
        for each in value if isinstance(value, tuple) else (value,):
            if isinstance(parameter, click.Argument):
                yield str(each)
            elif isinstance(each, bool):
                yield (parameter.opts if each else parameter.secondary_opts)[0]
            else:
                yield from (parameter.opts[0], str(each))


def names(text: str) -> list[str]:
    """Return the names in a comma-separated list."""
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def change_keys(text: str) -> Decorator:
    """Return the option --set with this help; a shell completes its keys."""
    text = f"{text} File names in values are relative to the folder of the file."
    return click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, shell_complete=keys, help=text)


def force_option(command: Any) -> Any:
    """Add the option --force to a command that writes files."""
    text = "Replace existing files. Of a symbolic link, the link is replaced, not its target."
    return click.option("--force", is_flag=True, help=text)(command)


def require_new_in(folder: str, files: tuple[str, ...], force: bool) -> None:
    """Raise OutputError if one of these files exists in a folder, unless `force` allows to replace it."""
    from pathlib import Path

    from cdpr.log.files import require_new

    for name in files:
        require_new(Path(folder) / name, force)


def plugin_option(flag: str, role: Role, *name: str, **more: Any) -> Decorator:
    """Return an option for names of plugins, with shell completion."""
    return click.option(flag, *name, shell_complete=plugins(role), **more)


def plugin_files(command: Any) -> Any:
    """Add the option --plugin to a command: its files are used until the command ends."""

    def use(context: click.Context, parameter: click.Parameter, files: tuple[str, ...]) -> None:
        if files and not context.resilient_parsing:
            from cdpr.plugins import registry

            context.meta[PLUGIN_FILES] = files
            context.call_on_close(partial(registry.use_files, registry.plugin_files()))
            registry.use_files(files)

    text = "Python file with your own backends, controllers, solvers or estimators; repeatable."
    return click.option("--plugin", metavar="FILE", multiple=True, expose_value=False, callback=use, help=text)(command)
