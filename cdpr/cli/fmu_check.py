"""`cdpr fmu check`."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING

import click

from cdpr.errors import ExitCode

if TYPE_CHECKING:
    from cdpr.fmu.signals import Role
    from cdpr.model import Robot

AS = click.option(
    "--as", "role", type=click.Choice(["plant", "winch", "controller"]), help="What the FMU is, instead of a guess."
)


@click.command("check")
@click.argument("file", type=click.Path())
@click.argument("robot", metavar="[ROBOT|SCENARIO]", required=False, type=click.Path())
@AS
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: str, robot: str | None, role: Role | None, as_json: bool) -> None:
    """Check the FMU in FILE: its file, its binary, the letter of the standard and, for a robot, its signals.

    The exit code is 2 if any check fails. Native code is not loaded.
    """
    from cdpr.fmu.archive import open_archive
    from cdpr.fmu.describe import check
    from cdpr.fmu.options import Signals

    archive = open_archive(file)
    results = list(check(archive, None if robot is None else load(robot), role, Signals()))
    if as_json:
        click.echo(json.dumps({"file": file, "checks": [dataclasses.asdict(each) for each in results]}, indent=2))
    else:
        width = max(len(each.id) for each in results)
        for each in results:
            click.echo(f"{each.outcome:<8}{each.id:<{width}}  {each.detail}".rstrip())
    if any(each.outcome == "failed" for each in results):
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)


def load(file: str) -> Robot:
    """Load a robot, or that of a scenario."""
    from cdpr.scenario import Scenario, load_any

    loaded = load_any(file)
    return loaded.robot if isinstance(loaded, Scenario) else loaded
