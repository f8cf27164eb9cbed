"""`cdpr fmu map`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import ExitCode
from cdpr.ui.cli.fmu_check import AS, load
from cdpr.ui.cli.names import plugin_files

if TYPE_CHECKING:
    from cdpr.fmu.read.signals import Role


@click.command("map")
@click.argument("file", type=click.Path())
@click.argument("robot", metavar="ROBOT|SCENARIO", type=click.Path())
@AS
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: str, robot: str, role: Role | None, as_json: bool) -> None:
    """Print the variables of the FMU in FILE by signal, as YAML for a scenario.

    Signals that a scenario assigns to that FMU are used. The exit code is 2 if signals are ambiguous: assign them
    yourself. Native code is not loaded.
    """
    from cdpr.fmu.read.archive import open_archive
    from cdpr.fmu.read.describe import guess_role
    from cdpr.fmu.read.mapping import resolve
    from cdpr.ui.report.text.fmu import yaml_lines

    archive = open_archive(file)
    model, role, signals = load(robot, file, role)
    role = role or guess_role(archive, model, signals)
    mapping, problems = resolve(archive.description, model, signals, role)
    if as_json:
        click.echo(json.dumps({**mapping.describe(), "problems": list(problems)}, indent=2))
    else:
        for line in yaml_lines(archive, mapping):
            click.echo(line)
    for problem in problems:
        click.echo(problem, err=True)
    if problems:
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)
