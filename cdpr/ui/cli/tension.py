"""`cdpr tension`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from cdpr.base.defaults import SOLVER
from cdpr.base.errors import PluginError
from cdpr.base.redirect_output import redirect_output
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files, plugin_option, require_new_in
from cdpr.ui.cli.names import names as listed

if TYPE_CHECKING:
    from pydantic import BaseModel

    from cdpr.analysis.distribution.comparison import Contestant
    from cdpr.model import Robot
    from cdpr.plugins.registry import Registered
    from cdpr.tension.stage import Solve


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
    from cdpr.scenario import Scenario
    from cdpr.ui.cli.load import load_with_warnings

    if out is not None:
        require_new_in(out, ("tension.json", "tension.svg"), force)
    loaded = load_with_warnings(file, changes)
    # imported only after the file is valid, because it is slow
    from cdpr.analysis.distribution.comparison import compare, describe
    from cdpr.log.run_json import to_json
    from cdpr.mechanics.dynamics import required_wrench
    from cdpr.mechanics.kinematics import make_state
    from cdpr.mechanics.properties import check_lengths
    from cdpr.tension.problem import Problem
    from cdpr.ui.cli.pose_option import parse_wrench, pose_and_gravity
    from cdpr.ui.cli.progress import Progress
    from cdpr.ui.report.text.distributions import lines

    robot, gravity, at, source = pose_and_gravity(loaded, pose)
    check_lengths(robot, at)
    if wrench is None:
        load, whence = required_wrench(robot, make_state(at[:3], at[3:]), gravity), "holds the weight"
    else:
        load, whence = parse_wrench(wrench, robot), "--wrench"
    own = (loaded.solver.type, loaded.solver_options) if isinstance(loaded, Scenario) else None
    controlled = loaded.controlled_robot if isinstance(loaded, Scenario) else robot
    problem = Problem(controlled, at, load)
    with Progress("solvers") as progress, redirect_output():
        answers = compare(problem, _contestants(names, controlled, own), progress)
    figures = to_json(describe(problem, answers, source, whence))
    if as_json:
        click.echo(json.dumps(figures, indent=2, allow_nan=False))
    else:
        for line in lines(figures):
            click.echo(line)
    if out is not None or not as_json:
        _write(figures, out, force or out is None, quiet=as_json)


def _contestants(names: Sequence[str], robot: Robot, own: tuple[str, BaseModel] | None) -> list[Contestant]:
    """Return the solvers of --solver; `own` is that of the scenario, with its options.

    Raises:
        PluginError: if a named solver is unknown or lacks a package.
    """
    from cdpr.analysis.distribution.comparison import Contestant
    from cdpr.plugins.registry import registry

    found = registry()
    chosen: dict[str, Registered] = {}
    for name in (one for text in names for one in listed(text)):
        for each in found.names("solver") if name == "all" else [name]:
            chosen[each] = found.get("solver", each)
            if name != "all":
                chosen[each].load()

    def contestant(name: str, entry: Registered) -> Contestant:
        def make() -> Solve:
            options = own[1] if own is not None and own[0] == name else entry.read_options({})
            solve: Solve = entry.make(robot, options).solve
            return solve

        absent = f"not installed: {entry.remedy}" if entry.missing else ""
        return Contestant(name, make, bool(entry.info.properties.get("respects_bounds", True)), absent)

    return [contestant(name, entry) for name, entry in chosen.items()]


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
