"""`cdpr workspace compare`."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import ExitCode, LogError
from cdpr.ui.cli.numbers import Whole

if TYPE_CHECKING:
    from cdpr.analysis.workspace.result import Workspace
    from cdpr.model import Robot


ORACLES = ("lp",)  # independent methods to evaluate poses


@click.command("compare")
@click.argument("file", type=click.Path())
@click.option("--oracle", type=click.Choice(ORACLES), default=ORACLES[0], help="Linear programs, by HiGHS. [lp]")
@click.option("--count", type=Whole(1, 10**6), default=200, show_default=True, metavar="N", help="Poses.")
@click.option("--seed", type=Whole(0, 2**63 - 1), default=0, show_default=True, metavar="N", help="Seed of the poses.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: str, oracle: str, count: int, seed: int, as_json: bool) -> None:
    """Verify poses of a workspace FILE by linear programs, half of them bisected onto its boundary.

    FILE must be of one of these kinds: static, wrench-feasible, dynamic, closure. Linear programs do not apply to the
    other kinds.

    The exit code is 7 if certain results differ.
    """
    from cdpr.analysis.workspace.oracle import compare
    from cdpr.analysis.workspace.result import load_workspace
    from cdpr.ui.cli.progress import Progress

    found = load_workspace(file)
    robot = robot_of(found, file)
    with Progress("poses") as progress:
        result = compare(found, robot, count, seed=seed, progress=progress)
    if as_json:
        click.echo(json.dumps(dataclasses.asdict(result), indent=1))
    else:
        click.echo(f"{found.robot}: {found.kind.name} workspace against {oracle}")
        click.echo(f"  poses                   {result.poses}, {result.bisected} of them on the boundary")
        click.echo(f"  undecided by either     {result.undecided}")
        if result.near:
            click.echo(f"  within 1e-9 of the end  {len(result.near)} that differ")
        click.echo(f"  different               {len(result.different)}")
        if result.told:
            click.echo(f"  interpolated            {result.told} cells, of which {result.told_wrong} are wrong")
        for each in result.different[:10]:
            click.echo(f"  at {each['position']}: {each['value']:.3g} here, {each['program']:.3g} there")
    if result.different:
        raise click.exceptions.Exit(ExitCode.DISAGREES)


def robot_of(found: Workspace, file: str) -> Robot:
    """Return the robot of a workspace.

    Raises:
        LogError: if its file does not contain it.
    """
    from cdpr.scenario import load_robot, load_scenario

    source = found.about.get("source", {})
    if "robot" in source:
        return load_robot(source["file"], text=source["robot"], overrides=source["changes"])
    if "scenario" in source:
        return load_scenario(source["file"], text=source["scenario"]).robot
    raise LogError(f"{file}: does not contain the robot; use a file written by 'cdpr workspace'")
