"""`cdpr import`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import ExitCode
from cdpr.ui.cli.names import OutPath, force_option
from cdpr.ui.cli.numbers import Real

if TYPE_CHECKING:
    from cdpr.formats.read.import_files import ImportResult


@click.command("import")
@click.argument("file", metavar="FILE|DIR", type=click.Path())
@click.option("--out", type=OutPath(path_type=Path), default=Path("."), help="Folder to write into. [.]")
@click.option("--cable-set", metavar="NAME", help="Cable set of a CASPR model. [its default]")
@click.option(
    "--trajectory", type=click.Path(), metavar="FILE", help="Trajectory file for a robot of the Gazebo plug-in."
)
@click.option(
    "--tension",
    metavar="MIN,MAX",
    callback=lambda context, option, text: _pair(text),
    help="Lowest and highest tension, N, of cables without limits in the file.",
)
@click.option("--seconds", type=Real(1.0), default=10.0, help="Limit of the CPU time for reading a file. [10]")
@force_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    file: str,
    out: Path,
    cable_set: str | None,
    trajectory: str | None,
    tension: tuple[float, float] | None,
    seconds: float,
    force: bool,
    as_json: bool,
) -> None:
    """Read a robot and its motions from another program's file, and write robot and scenario files.

    Supported are CASPR, WireX, MuJoCo (MJCF), Gazebo (the plug-in's YAML, or SDF with legs), RepRapFirmware (config.g),
    Klipper (printer.cfg), CDPyR (JSON, YAML, XML), and lists of anchors (JSON, YAML, CSV); the format is detected by
    the content of FILE. In a folder all readable files are imported, and a table lists the others with reasons. Every
    number has a comment with its source; the head of the file lists omitted content.
    """
    from cdpr.formats.read.import_files import import_any, write

    every = import_any(file, cable_set=cable_set, trajectory=trajectory, tension=tension, seconds=seconds)
    rows = []
    for each in every:
        written = write(each, out, force=force, otherwise="choose another --out, or --force")
        rows.append({**vars(each), "files": [str(name) for name in written]})
        if not as_json:
            _print_result(each, written)
    if as_json:
        click.echo(json.dumps(rows, indent=1))
    elif len(foreign := [each for each in every if not each.own]) > 1:
        failed = sum(bool(each.error) for each in foreign)
        click.echo(f"{len(foreign) - failed} of {len(foreign)} could be read")
    if all(each.error for each in every):
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)


def _pair(text: str | None) -> tuple[float, float] | None:
    """Return the two numbers of an option."""
    if text is None:
        return None
    try:
        low, high = map(float, text.split(","))
    except ValueError:
        raise click.BadParameter(f"expected two numbers with a comma between, such as 5,500, got '{text}'") from None
    return low, high


def _print_result(each: ImportResult, written: list[Path]) -> None:
    if each.error:
        click.echo(each.error if each.own else f"not read: {each.error}")
        return
    click.echo(f"{each.source}: {', '.join(map(str, written))}")
    for text in each.warnings:
        click.echo(f"warning: {text}", err=True)
    for text in each.left_out:
        click.echo(f"left out: {text}", err=True)
