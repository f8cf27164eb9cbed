"""`cdpr bench`."""

from __future__ import annotations

import json
from typing import Any

import click

from cdpr.base.errors import CdprError, ExitCode
from cdpr.base.redirect_output import redirect_output
from cdpr.ui.cli.names import OutPath, force_option, names, plugin_files, plugin_option, require_new_in
from cdpr.ui.cli.numbers import Whole
from cdpr.ui.cli.progress import Progress

# Robots of redundancies 0 to 6, suspended and fully constrained, spatial and planar.
ROBOTS = ("caroca", "thesis", "planar", "point_mass", "seven", "crossed", "nine", "twelve")


@click.group("bench")
def command() -> None:
    """Compare installed plugins."""


@command.command("solvers")
@click.argument("robots", metavar="[ROBOT]...", nargs=-1, type=click.Path())
@click.option("--poses", type=Whole(1, 1_000_000), default=500, show_default=True, help="Problems per robot.")
@click.option(
    "--adversaries",
    type=Whole(0, 1_000_000),
    default=500,
    show_default=True,
    help="Adversarial problems for each of eleven sizes of robots.",
)
@click.option("--seed", type=Whole(0), default=1, show_default=True, help="Seed of all random numbers.")
@plugin_option("--solvers", "solver", default="all", show_default=True, metavar="A,B|all", help="Names of the solvers.")
@click.option(
    "--set", "changes", metavar="SOLVER.KEY=VALUE", multiple=True, help="An option of one of the solvers; repeatable."
)
@plugin_files
@click.option("--out", type=OutPath(), help="Folder for bench.json, bench.html and the figures.")
@force_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def solvers(
    robots: tuple[str, ...],
    poses: int,
    adversaries: int,
    seed: int,
    solvers: str,
    changes: tuple[str, ...],
    out: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Solve the same random problems by all tension solvers and compare coverage, accuracy, jumps and time.

    Further problems are adversarial: no answer reported as OK should be wrong. ROBOTs are robot files or names of
    examples; the default is eight examples. Ctrl-C keeps the results so far.
    """
    from pathlib import Path

    from cdpr.scenario import load_robot

    options = _options(changes)
    loaded = [load_robot(path) for path in robots or ROBOTS]
    if out is not None:
        from cdpr.ui.report.pages.bench import drawing_name

        drawn = (drawing_name(k, robot.name) for k, robot in enumerate(loaded, 1))
        require_new_in(out, ("bench.json", "bench.html", *drawn), force)
    chosen = None if solvers == "all" else names(solvers)
    # imported only after the files are valid, because it is slow
    from cdpr.analysis import bench
    from cdpr.log.run_json import to_json

    with Progress(at_once=True) as progress, redirect_output():
        figures = to_json(
            bench.run(loaded, chosen, poses, seed, adversaries=adversaries, progress=progress, options=options)
        )
    if out is not None:
        from cdpr.ui.report.pages.bench import write_bench

        write_bench(figures, Path(out), force)
    if as_json:
        click.echo(json.dumps(figures, indent=1, allow_nan=False))
    else:
        _print(figures)
        if out is not None:
            click.echo(Path(out) / "bench.html")
    if figures["interrupted"]:
        click.echo("interrupted: incomplete measurement", err=True)
        raise click.exceptions.Exit(ExitCode.INTERRUPTED)


def _options(changes: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """Return the options of `--set` by solver."""
    from cdpr.config.yaml_nodes import parse_value

    options: dict[str, dict[str, Any]] = {}
    for change in changes:
        key, equals, value = change.partition("=")
        solver, _, option = key.rpartition(".")
        if not (solver and option and equals):
            raise CdprError(f"--set {change}: expected SOLVER.KEY=VALUE, such as osqp.iterations=200")
        try:
            options.setdefault(solver, {})[option] = parse_value(value)
        except ValueError as error:
            raise CdprError(f"--set {change}: {error}") from None
    return options


def _print(figures: dict[str, Any]) -> None:
    """Print one table per robot, then the unusable solvers and the meaning of the columns."""
    from cdpr.ui.report.text.aligned import table, wrapped
    from cdpr.ui.report.text.bench import COLUMNS, MEANING, MISLED, NOTHING, cells, facts

    shown = [(robot, COLUMNS) for robot in figures["robots"]] + [(robot, MISLED) for robot in figures["adversaries"]]
    for robot, columns in shown:
        lines = wrapped(f"{robot['name']}: {facts(robot)}", 0)
        rows = [[row["solver"], *(cells(row, columns) or [NOTHING] * len(columns))] for row in robot["results"]]
        lines += table([["solver", *columns], *rows], indent="", ruled=True)
        lines += [f"{row['solver']} failed: {row['detail']}" for row in robot["results"] if row["outcome"] == "failed"]
        for line in (*lines, ""):
            click.echo(line)
    for solver in figures["solvers"]:
        if solver["problem"]:
            click.echo(f"skipped: {solver['problem']}")
    for line in table(MEANING.items(), left=2, indent=""):
        click.echo(line)
