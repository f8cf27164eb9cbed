"""`cdpr tension`."""

from __future__ import annotations

import json
from typing import Any

import click

from cdpr.base.defaults import SOLVER
from cdpr.base.errors import PluginError
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files, plugin_option, require_new_in
from cdpr.ui.cli.names import names as listed


@click.command("tension")
@click.argument("file", metavar="ROBOT|SCENARIO", type=click.Path())
@click.option(
    "--pose", metavar="X,Y,Z[,R,P,Y]", help="Evaluated pose: position (m) and roll, pitch, yaw (rad, or as 30deg)."
)
@click.option(
    "--wrench", metavar="FX,FY,FZ[,MX,MY,MZ]", help="Wrench of the cables on the platform (N, N m), world axes."
)
@plugin_option(
    "--solver",
    "solver",
    "names",
    metavar="NAME",
    multiple=True,
    default=[SOLVER],
    help=f"Repeatable, or several with commas; `all` for all. [{SOLVER}]",
)
@change_keys("Change any key of the file.")
@click.option("--out", type=OutPath(), help="Folder for the picture (tension.svg) and the figures (tension.json).")
@force_option
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    file: str,
    pose: str | None,
    wrench: str | None,
    names: tuple[str, ...],
    changes: tuple[str, ...],
    out: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Distribute one wrench at one pose among the cables, with one solver, several or all, and compare the answers.

    The wrench is force and moment about the platform's origin, world axes; the default balances the weight. The default
    of --pose is the robot's home, or the scenario's initial pose. Every answer is checked. With redundant cables, the
    command draws all admissible tensions; with more than two redundant cables, it draws the range of each tension.
    """
    from cdpr.ui.cli.load import load_with_warnings

    if out is not None:
        require_new_in(out, ("tension.json", "tension.svg"), force)
    loaded = load_with_warnings(file, changes)
    # imported only after the file is valid, because it is slow
    from cdpr.analysis.distribution.solvers import compare_solvers
    from cdpr.model import Robot
    from cdpr.ui.cli.pose_option import parse_pose, parse_wrench
    from cdpr.ui.cli.progress import Progress
    from cdpr.ui.report.text.distributions import lines

    robot = loaded if isinstance(loaded, Robot) else loaded.robot
    at = None if pose is None else parse_pose(pose, robot)
    load = None if wrench is None else parse_wrench(wrench, robot)
    with Progress("solvers") as progress:
        solvers = [one for text in names for one in listed(text)]
        figures = compare_solvers(loaded, at, load, solvers=solvers, progress=progress)
    for name, given in (("pose", at), ("wrench", load)):
        if given is not None:
            figures[name]["source"] = f"--{name}"
    if as_json:
        click.echo(json.dumps(figures, indent=2, allow_nan=False))
    else:
        for line in lines(figures):
            click.echo(line)
    if out is not None or not as_json:
        _write(figures, out, force or out is None, quiet=as_json)


def _write(figures: dict[str, Any], out: str | None, force: bool, *, quiet: bool) -> None:
    """Write picture and figures into a folder, which is created if necessary, and print the path."""
    from pathlib import Path

    from cdpr.log.files import markup, replace_all
    from cdpr.log.run_folder import RUNS, safe_name
    from cdpr.ui.report.text.distributions import no_picture

    folder = Path(out) if out is not None else RUNS / "tension" / safe_name(figures["robot"])
    files: dict[str, str | bytes] = {"tension.json": json.dumps(figures, indent=2, allow_nan=False) + "\n"}
    if no_picture(figures) is None:
        try:
            from cdpr.ui.report.figures.null_space import draw_null_space

            files["tension.svg"] = markup(draw_null_space(figures))
        except PluginError as error:
            click.echo(f"no picture: {error}", err=True)
    replace_all(folder, files, force)
    if not quiet:
        click.echo(folder / [*files][-1])
