"""`cdpr baseline`."""

from __future__ import annotations

import dataclasses
import json

import click

from cdpr.base.errors import ExitCode
from cdpr.ui.cli.names import OutPath, change_keys, force_option, names, plugin_files, plugin_option
from cdpr.ui.cli.numbers import Whole
from cdpr.ui.cli.progress import Progress, terminating


@click.group("baseline")
def command() -> None:
    """Save runs as small baseline files, and check later for differences."""


@command.command("save")
@click.argument("scenarios", metavar="SCENARIO...", nargs=-1, required=True, type=click.Path())
@click.option("--out", required=True, type=OutPath(), help="Folder for the baselines, one file each.")
@force_option
@plugin_option("--backends", "backend", metavar="A,B", help="Engines, instead of each scenario's own.")
@change_keys("Change a key of all scenarios; repeatable.")
@plugin_files
@click.option("--jobs", type=Whole(1), default=1, show_default=True, help="Number of parallel processes.")
def save(
    scenarios: tuple[str, ...], out: str, force: bool, backends: str | None, changes: tuple[str, ...], jobs: int
) -> None:
    """Run SCENARIOs and save baselines."""
    from pathlib import Path

    from cdpr.analysis.compare import baseline_check
    from cdpr.log.files import NAME_OR_FORCE

    chosen = None if backends is None else names(backends)
    with terminating(), Progress("runs") as progress:
        files = baseline_check.save(
            scenarios,
            Path(out),
            backends=chosen,
            overrides=changes,
            jobs=jobs,
            progress=progress,
            force=force,
            remedy=NAME_OR_FORCE,
        )
    for file in files:
        click.echo(file)


@command.command("check")
@click.argument("folder", type=click.Path(exists=True))
@plugin_files
@click.option("--jobs", type=Whole(1), default=1, show_default=True, help="Number of parallel processes.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def check(folder: str, jobs: int, as_json: bool) -> None:
    """Repeat the baselines in FOLDER, or one file.

    With the same versions on the same type of machine a run must have the same bits, otherwise it must be within the
    bounds of its file. The exit code is 7 if a run differs.
    """
    from pathlib import Path

    from cdpr.analysis.compare import baseline_check

    with terminating(), Progress("runs") as progress:
        found = baseline_check.check(Path(folder), jobs=jobs, progress=progress)
    if as_json:
        click.echo(json.dumps([dataclasses.asdict(one) for one in found], indent=1))
    else:
        from cdpr.ui.report.text.aligned import table

        rows = [(one.name, f"{one.outcome}{f': {one.detail}' if one.detail else ''}") for one in found]
        for line in table(rows, left=2, indent=""):
            click.echo(line)
    if not all(one.agrees for one in found):
        raise click.exceptions.Exit(ExitCode.DISAGREES)
