"""`cdpr new`."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from cdpr.base.errors import CdprError, OutputError
from cdpr.ui.cli.numbers import AnyReal, AnyWhole, number

if TYPE_CHECKING:
    from cdpr.scenario.template import Sizes

STDOUT = "-"


def _lengths(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[float, float, float] | None:
    """Return three lengths, m."""
    if value is None:
        return None
    try:
        x, y, z = (number(part) for part in value.split(","))
    except ValueError:
        text = f"expected three lengths (m) with commas between them, such as 4,3,2.5, got {value[:80]!r}"
        raise click.BadParameter(text) from None
    return x, y, z


def sizes(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of a new robot's sizes to a command, which receives the given ones."""
    options = [
        click.option(
            "--frame", callback=_lengths, metavar="W,D,H", help="Width, depth, height of the frame (m): 4,3,2.5."
        ),
        click.option(
            "--platform", callback=_lengths, metavar="W,D,H", help="The same for the platform (m): 0.4,0.3,0.2."
        ),
        click.option("--mass", type=AnyReal(), metavar="KG", help="Mass of the platform (kg): 20."),
        click.option(
            "--cables",
            type=AnyWhole(),
            metavar="N",
            help="Number of cables: 7 or 8; suspended 6 or 8, point mass 3 or 4; planar 4. [8; planar 4]",
        ),
        click.option(
            "--suspended", is_flag=True, default=None, help="All cables from above; the default for 3, 4 and 6 cables."
        ),
        click.option("--crossed/--straight", default=None, help="Cross the cables at the platform, the default."),
        click.option("--planar", is_flag=True, default=None, help="Planar robot in x and z."),
    ]
    for option in reversed(options):
        command = option(command)
    return command


@click.group("new")
def command() -> None:
    """Write a working robot or scenario file to edit, with a comment on every key."""


@command.command("robot")
@click.argument("file", default="robot.yaml", type=click.Path())
@sizes
def robot(file: str, **given: Any) -> None:
    """Write a robot FILE (default: robot.yaml; - prints it): a box in a frame, on cables from its corners.

    Tension limits follow from the mass. Sizes for which the cables cannot balance the weight are rejected. Cables touch
    neither each other nor the platform in most of the static workspace; otherwise a warning is shown.
    """
    from cdpr.scenario.template import crowded, robot_text

    chosen = _sizes(given)
    text = robot_text(file, chosen, _stem(file, "robot"))
    _write(file, text, f"cdpr info {shlex.quote(file)}", crowded(chosen))


@command.command("scenario")
@click.argument("file", default="scenario.yaml", type=click.Path())
@click.option(
    "--robot", "source", type=click.Path(), help="Robot file or example; by default the scenario contains a new robot."
)
@sizes
def scenario(file: str, source: str | None, **given: Any) -> None:
    """Write a scenario FILE (default: scenario.yaml; - prints it): a slow feasible move of its robot."""
    from cdpr.scenario.template import RESTS, crowded
    from cdpr.simulation.trial_runs import scenario_with_trials

    extra = [f"--{key}" for key, value in given.items() if value is not None]
    if source is not None and extra:
        raise CdprError(f"{', '.join(extra)}: sizes are those of the robot file; leave them out, or --robot")
    chosen = _sizes(given)
    trial = scenario_with_trials(file, source, chosen)
    warning = None if source is not None else crowded(chosen)
    _write(file, trial.text, f"cdpr run {shlex.quote(file)}", warning)
    if trial.note:
        click.echo(trial.note, err=True)
    if RESTS in trial.text and file != STDOUT:
        click.echo(f"{RESTS} 'cdpr info {shlex.quote(file)}' shows details; a trajectory can be written in", err=True)


def _sizes(given: dict[str, Any]) -> Sizes:
    from cdpr.scenario.template import Sizes

    return Sizes(**{key: value for key, value in given.items() if value is not None})


def _stem(file: str, otherwise: str) -> str:
    from cdpr.scenario.source import stem

    return otherwise if file == STDOUT else stem(file)


def _write(file: str, text: str, then: str, warning: str | None) -> None:
    """Write a new file or print it; an existing file is not replaced."""
    if file == STDOUT:
        if warning:
            click.echo(f"warning: {warning}", err=True)
        click.echo(text, nl=False)
        return
    from pathlib import Path

    from cdpr.log.files import create

    try:
        create(Path(file), text)
    except FileExistsError:
        raise OutputError(f"'{file}' already exists and is not overwritten: choose another name") from None
    except FileNotFoundError:
        raise OutputError(f"cannot write '{file}': there is no folder '{Path(file).parent}'; create it first") from None
    except OSError as error:
        raise OutputError(f"cannot write '{file}': {error.strerror}") from None
    from cdpr.ui.cli.load import load_with_warnings

    click.echo(file)
    load_with_warnings(file, ())  # prints warnings on unusual sizes
    if warning:
        click.echo(f"warning: {file}: {warning}", err=True)
    click.echo(f"next: {then}", err=True)
