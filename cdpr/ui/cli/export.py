"""`cdpr export`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cdpr.formats.write import TARGETS
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files

if TYPE_CHECKING:
    from cdpr.log.run import Run
    from cdpr.model import Robot
    from cdpr.scenario import Scenario

TABLES = ("csv", "npz", "mat", "parquet")
PACKAGE = "ros2"  # a folder of packages, not a file
NATIVE = "native"  # a folder with a C++ header and its numbers
SCENARIO_ONLY = {  # reasons why these formats require a scenario
    PACKAGE: "ros2 requires a scenario, which the node runs, got a robot",
    NATIVE: "native requires a scenario (for its controller), got a robot",
}


@click.command("export")
@click.argument("what", metavar="RUN|ROBOT|SCENARIO", type=click.Path())
@change_keys("Change a key of the robot or scenario; repeatable.")
@click.option(
    "--to",
    type=click.Choice([*TABLES, *TARGETS, PACKAGE, NATIVE]),
    required=True,
    help="Run: csv, npz, mat or parquet (the last two require the extra `data`). Robot: mjcf, sdf or urdf. Scenario: "
    "ros2 (folder of packages) or native (C++ header and numbers for real-time programs).",
)
@click.option("--style", help="For SDF: platform (moved by a wrench) or legs (which push and pull). [platform]")
@click.option("--sdf-version", "version", help="1.9, or 1.6 for older readers. [1.9]")
@click.option("--pulleys-as-points", is_flag=True, help="Replace pulleys by points, for MJCF and SDF, which have none.")
@click.option("--out", type=OutPath(path_type=Path), help="File; default: run.FORMAT beside the log, or ROBOT.FORMAT.")
@force_option
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    what: str,
    changes: tuple[str, ...],
    to: str,
    style: str | None,
    version: str | None,
    pulleys_as_points: bool,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Write a robot or scenario for MuJoCo, Gazebo, RViz, ROS 2 or real time; a run as CSV, NumPy, MATLAB or Parquet.

    A run is its folder or log; a scenario is exported at its start, a robot at its home.
    """
    given = {"style": style, "version": version, "pulleys": "points" if pulleys_as_points else None}
    takes = TARGETS[to].options if to in TARGETS else ()
    for name, value in given.items():
        if value is not None and name not in takes:
            option = {"version": "sdf-version", "pulleys": "pulleys-as-points"}.get(name, name)
            formats = " or ".join(f"--to {each}" for each, target in TARGETS.items() if name in target.options)
            raise click.UsageError(f"--{option} is for {formats}")
    if to in TABLES and changes:
        raise click.UsageError("--set applies to robots and scenarios, not to runs")
    from cdpr.formats.write.export import write
    from cdpr.formats.write.export_model import Options
    from cdpr.ui.cli.load import print_lines

    loaded = _run(what, to) if to in TABLES else _robot(what, changes, to)
    if to in TABLES and out is None:
        from cdpr.log.reader import locate

        out = locate(what)[0].with_name(f"run.{to}")
    written = write(loaded, to, out, Options(**{name: value for name, value in given.items() if value}), force=force)
    print_lines(f"left out: {each}" for each in written.omitted)
    if as_json:
        click.echo(json.dumps({"file": str(written.path), "format": to, **written.counts}))
    else:
        click.echo(": ".join([str(written.path), *(f"{value} {name}" for name, value in written.counts.items())]))


def _run(run: str, to: str) -> Run:
    from cdpr.base.errors import CdprError
    from cdpr.log.reader import load_run

    if run.endswith((".yaml", ".yml")):
        others = ", ".join([*TARGETS, PACKAGE, NATIVE])
        raise CdprError(f"{run}: {to} is for runs, and this is a file of a robot or scenario: {others}")
    return load_run(run)


def _robot(file: str, changes: tuple[str, ...], to: str) -> Robot | Scenario:
    from cdpr.base.errors import CdprError
    from cdpr.scenario import Scenario
    from cdpr.scenario.examples import is_run
    from cdpr.ui.cli.load import load_with_warnings

    if to in TARGETS and is_run(file):
        raise CdprError(f"{file}: {to} is for robots and scenarios, and this is a run: {', '.join(TABLES)}")
    loaded = load_with_warnings(file, changes)
    if to not in TARGETS and not isinstance(loaded, Scenario):
        raise CdprError(f"{file}: {SCENARIO_ONLY[to]}: 'cdpr new scenario --robot FILE' writes one")
    return loaded
