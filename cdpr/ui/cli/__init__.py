"""Command line: one module per command, imported only when it is called."""

from __future__ import annotations

import atexit
import contextlib
import gc
import io
import os
import sys
import threading
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from itertools import compress
from types import MappingProxyType
from typing import Any

import click

from cdpr.base.errors import CdprError, ExitCode, OptionsLeftOut, one_line
from cdpr.base.nearest import did_you_mean
from cdpr.base.version import VERSION
from cdpr.ui.cli.streams import UNWRITABLE, printable_streams, streams
from cdpr.ui.cli.unknown_options import with_hint

DEBUG = "CDPR_DEBUG"
GARBAGE = 100_000  # allocations between two garbage collections
SHOWN = 60  # characters shown of an unknown command

# Name -> one line of help, so that `cdpr --help` imports no command.
COMMANDS = {
    "run": "Simulate a scenario and write log, summary and report.",
    "examples": "List the examples of cdpr, or copy one.",
    "view": "Show runs, a robot or a motion in an animated page.",
    "gui": "Open a window that edits a scenario, runs it and steers the run.",
    "new": "Write a working robot or scenario file to edit.",
    "info": "Analyse a robot, or the motion of a scenario, without simulating it.",
    "tension": "Distribute a wrench at a pose with one solver, several or all, and compare.",
    "equilibrium": "Compute the pose at rest for cable lengths, or the lengths for a pose.",
    "solvers": "List the tension solvers with their objectives and guarantees.",
    "workspace": "Compute workspaces: feasible poses, wrenches and accelerations.",
    "design": "Optimise keys of a robot within bounds, under constraints.",
    "size": "Size cables, drums and motors over scenarios and runs.",
    "validate": "Check scenario and robot files.",
    "schema": "Print the JSON Schema of scenarios or robots, for editors.",
    "compare": "Run a scenario on several engines, or compare finished runs.",
    "baseline": "Save runs as small baseline files, and check later for differences.",
    "study": "Run a scenario with any of its keys varied, on all cores or a cluster.",
    "check": "Check an installed backend, solver, controller or estimator against the rules of its role.",
    "bench": "Compare installed tension solvers: coverage, accuracy, jumps, time.",
    "fmu": "Export, inspect, map and trust FMUs.",
    "doctor": "Check the installation, and show what to install.",
    "plugins": "List backends, controllers, solvers and estimators, and their problems.",
    "import": "Import a robot of CASPR, Gazebo, WireX or MuJoCo.",
    "export": "Write a robot for MuJoCo, Gazebo, RViz or ROS 2, or a run as CSV, NumPy, MATLAB or Parquet.",
    "repair": "Repair the log of a killed run.",
}


# Groups of `cdpr --help` by task; commands without a group come last.
GROUPS = {
    "Start": ("examples", "new", "gui", "doctor"),
    "Run and compare": ("run", "validate", "view", "compare", "study", "baseline"),
    "Analyse a robot": ("info", "tension", "equilibrium", "solvers", "workspace", "size", "design"),
    "Import and export": ("import", "export", "fmu", "schema", "repair"),
    "Plugins": ("plugins", "check", "bench"),
}


class LazyGroup(click.Group):
    """Group that imports a command when it is used: the object `command` of the module `cdpr.ui.cli.<prefix><name>`.

    `table` has the name and one line of help of each command, `groups` the names by heading of the list, if any.
    """

    def __init__(
        self,
        *args: Any,
        table: dict[str, str],
        prefix: str = "",
        groups: Mapping[str, Sequence[str]] = MappingProxyType({}),
        **options: Any,
    ) -> None:
        super().__init__(*args, **options)
        self.table = table
        self.groups = groups
        self.prefix = prefix

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of the table."""
        return list(self.table)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command."""
        if cmd_name not in self.table:
            return None
        command: click.Command = import_module(f"cdpr.ui.cli.{self.prefix}{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command; the error for an unknown one suggests the nearest name."""
        name = args[0]
        if name not in self.table and not name.startswith("-"):
            hint = did_you_mean(name, self.table).replace("did", "Did", 1)
            ctx.fail(f"No such command {name[:SHOWN]!r}. {hint}There are {', '.join(self.table)}.")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands from the table alone."""
        grouped = {name for names in self.groups.values() for name in names}
        rest = [name for name in self.table if name not in grouped]
        widest = max(map(len, self.table))
        for heading, names in (*self.groups.items(), ("Others" if grouped else "Commands", rest)):
            if names:
                with formatter.section(heading):
                    formatter.write_dl([(name.ljust(widest), self.table[name]) for name in names])


@click.group(cls=LazyGroup, table=COMMANDS, groups=GROUPS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(VERSION, prog_name="cdpr")
def cli() -> None:
    """Simulate and analyse cable-driven parallel robots."""


@printable_streams()
def main() -> None:
    """Run the command line; every error meant for the user becomes a text and an exit code, never a traceback."""
    # Nearly all objects of a command live to its end: Python's default collection takes a tenth of the time.
    gc.set_threshold(GARBAGE)
    atexit.unregister(_leave_all_as_it_is)  # of an earlier call in the same process
    atexit.register(_leave_all_as_it_is)
    warnings.simplefilter("ignore", OptionsLeftOut)  # commands report `Scenario.notes`
    # show warnings to the user without their place in the code
    warnings.showwarning = lambda message, *_, **__: click.echo(f"warning: {message}", err=True)
    try:
        with streams():
            code = cli.main(prog_name="cdpr", standalone_mode=False)
    except click.exceptions.Abort:
        code = ExitCode.INTERRUPTED
    except KeyboardInterrupt:
        code = ExitCode.INTERRUPTED
    except click.ClickException as error:
        with_hint(error, sys.argv[1:]).show()
        code = ExitCode.BAD_INPUT
    except CdprError as error:
        if os.environ.get(DEBUG):
            raise
        click.echo(str(error), err=True)
        code = error.exit_code
    except OSError as error:
        click.echo(f"{UNWRITABLE}: {error}", err=True)
        code = ExitCode.NOT_WRITABLE
    except MemoryError as error:
        if os.environ.get(DEBUG):
            raise
        reason = f" ({error})" if str(error) else ""
        click.echo(f"not enough memory{reason}: reduce the task, or close other programs", err=True)
        code = ExitCode.INTERNAL
    except Exception as error:
        if os.environ.get(DEBUG):
            raise
        click.echo(
            f"internal error: {one_line(error)}\n"
            f"This is a bug in cdpr or in a plugin, not in your input; set {DEBUG}=1 for a traceback.",
            err=True,
        )
        code = ExitCode.INTERNAL
    _leave(int(code or 0))


def _leave_all_as_it_is() -> None:
    """Skip the destruction of objects at exit, which would take a fifth of a short run.

    Destruction would also flush files that a plugin has not closed, so this function flushes them.
    """
    kinds = {io.TextIOWrapper, io.BufferedWriter, io.BufferedRandom}
    objects = gc.get_objects()
    for each in list(compress(objects, map(kinds.__contains__, map(type, objects)))):  # a loop is three times slower
        with contextlib.suppress(OSError, ValueError):
            each.flush()
    gc.freeze()


def _leave(code: int) -> None:
    """End the process; if one of our threads is still active, skip the cleanup, which would crash an engine in it."""
    # An interrupt that passed through code generated from text, such as that of dataclasses, would kill `python -m
    # cdpr` here even if it was handled; executing another text clears it.
    exec("")
    if not any(thread.daemon and thread.name.startswith("cdpr") for thread in threading.enumerate()):
        sys.exit(code)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, full, or missing
            stream.flush()
    os._exit(code)
