"""`cdpr export`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cdpr.formats.write import TARGETS
from cdpr.ui.cli.names import OutPath, change_keys, plugin_files

if TYPE_CHECKING:
    from cdpr.scenario import Scenario

TABLES = ("csv", "npz", "mat", "parquet")
PACKAGE = "ros2"  # a folder of packages, not a file
NATIVE = "native"  # a folder with a C++ header and its numbers


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
@click.option("--force", is_flag=True, help="Replace the file if it exists.")
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
    if to == PACKAGE:
        if force:
            raise click.UsageError("--force applies to files only; ros2 requires a new or empty folder")
        file, lines = _packages(what, changes, out)
    elif to == NATIVE:
        file, lines = _native(what, changes, out, force)
    elif to in TABLES:
        if changes:
            raise click.UsageError("--set applies to robots and scenarios, not to runs")
        file, lines = _run(what, to, out, force)
    else:
        file, lines = _robot(what, changes, to, {name: value for name, value in given.items() if value}, out, force)
    if as_json:
        click.echo(json.dumps({"file": str(file), "format": to, **lines}))
    else:
        click.echo(": ".join([str(file), *(f"{value} {name}" for name, value in lines.items())]))


def _run(run: str, to: str, out: Path | None, force: bool) -> tuple[Path, dict[str, int]]:
    from cdpr.base.errors import CdprError
    from cdpr.log.export import export
    from cdpr.log.reader import load_run, locate

    if run.endswith((".yaml", ".yml")):
        others = ", ".join([*TARGETS, PACKAGE, NATIVE])
        raise CdprError(f"{run}: {to} is for runs, and this is a file of a robot or scenario: {others}")
    log, _ = locate(run)
    out = out or log.with_name(f"run.{to}")
    loaded = load_run(run)
    export(loaded, to, out, force)
    return out, {"rows": len(loaded.rows)}


def _packages(file: str, changes: tuple[str, ...], out: Path | None) -> tuple[Path, dict[str, int]]:
    from cdpr.formats.write.ros2 import write_ros2
    from cdpr.ui.cli.load import print_lines

    loaded = _scenario(file, changes, f"{PACKAGE} is for scenarios, for a node runs one, and this is a robot")
    out = out or Path(f"{loaded.name}_ros2")
    files, omitted = write_ros2(loaded, out)
    print_lines(f"left out: {each}" for each in omitted)
    return out, {"files": len(files)}


def _native(file: str, changes: tuple[str, ...], out: Path | None, force: bool) -> tuple[Path, dict[str, int]]:
    from cdpr.formats.write.native import write_native
    from cdpr.simulation.needs import omitted
    from cdpr.ui.cli.load import print_lines

    loaded = _scenario(file, changes, f"{NATIVE} requires a scenario (for its controller), got a robot")
    print_lines(f"left out: {each}" for each in omitted(loaded, "native"))
    out = out or Path(f"{loaded.name}_native")
    return out, {"files": len(write_native(loaded, out, force))}


def _scenario(file: str, changes: tuple[str, ...], refusal: str) -> Scenario:
    from cdpr.base.errors import CdprError
    from cdpr.scenario import Scenario
    from cdpr.ui.cli.load import load_with_warnings

    loaded = load_with_warnings(file, changes)
    if not isinstance(loaded, Scenario):
        raise CdprError(f"{file}: {refusal}: 'cdpr new scenario --robot FILE' writes one")
    return loaded


def _robot(
    file: str, changes: tuple[str, ...], to: str, given: dict[str, str], out: Path | None, force: bool
) -> tuple[Path, dict[str, int]]:
    from cdpr.base.errors import CdprError
    from cdpr.formats.write.export_model import Options, begin, export, left_out
    from cdpr.log.files import make_folder, replace, require_new
    from cdpr.scenario.examples import is_run
    from cdpr.ui.cli.load import load_with_warnings, print_lines

    if is_run(file):
        raise CdprError(f"{file}: {to} is for robots and scenarios, and this is a run: {', '.join(TABLES)}")
    subject = begin(load_with_warnings(file, changes), to)
    text = export(subject, to, Options(**given))
    print_lines(f"left out: {each}" for each in left_out(subject, to))
    out = out or Path(f"{subject.robot.name}{TARGETS[to].ending}")
    require_new(out, force)
    make_folder(out.parent)
    replace(out, text)
    return out, {}
