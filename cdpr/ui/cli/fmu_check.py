"""`cdpr fmu check`."""

from __future__ import annotations

import dataclasses
import json
import os
from typing import TYPE_CHECKING, Any

import click

from cdpr.base.errors import ExitCode
from cdpr.ui.cli.names import plugin_files

if TYPE_CHECKING:
    from cdpr.fmu.read.options import Signals
    from cdpr.fmu.read.signals import Role
    from cdpr.model import Robot

AS = click.option(
    "--as", "role", type=click.Choice(["plant", "winch", "controller"]), help="Role of the FMU (default: detected)."
)


@click.command("check")
@click.argument("file", type=click.Path())
@click.argument("robot", metavar="[ROBOT|SCENARIO]", required=False, type=click.Path())
@AS
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: str, robot: str | None, role: Role | None, as_json: bool) -> None:
    """Check the FMU in FILE: its file, its binary, the letter of the standard and, for a robot, its signals.

    Signals that a scenario assigns to that FMU are used. The exit code is 2 if any check fails. Native code is not
    loaded.
    """
    from cdpr.fmu.read.archive import open_archive
    from cdpr.fmu.read.describe import check
    from cdpr.ui.report.text.aligned import table

    archive = open_archive(file)
    results = list(check(archive, *((None, role, None) if robot is None else load(robot, file, role))))
    if as_json:
        click.echo(json.dumps({"file": file, "checks": [dataclasses.asdict(each) for each in results]}, indent=2))
    else:
        for line in table([(each.outcome, each.id, each.detail) for each in results], left=3, indent=""):
            click.echo(line)
    if any(each.outcome == "failed" for each in results):
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)


def load(file: str, fmu: str, role: Role | None) -> tuple[Robot, Role | None, Signals | None]:
    """Return the robot and, if a scenario uses `fmu`, the role and signals that it defines."""
    from cdpr.fmu.read.options import FmuFile
    from cdpr.scenario import Scenario, load_any

    loaded = load_any(file)
    if not isinstance(loaded, Scenario):
        return loaded, role, None
    parts: list[tuple[Role, Any]] = [
        ("plant", loaded.backend_options(name)) for name in loaded.sections.backend_options
    ]
    for use, options in [*parts, ("winch", loaded.actuators), ("controller", loaded.controller_options)]:
        if isinstance(options, FmuFile) and role in (None, use) and _same(options, fmu):
            robot = loaded.nominal if use == "controller" and loaded.nominal else loaded.robot
            return robot, use, options.signals
    return loaded.robot, role, None


def _same(options: Any, fmu: str) -> bool:
    """Return True if the options refer to that file."""
    return options.file is not None and os.path.realpath(options.file.path) == os.path.realpath(fmu)
