"""`cdpr study`."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import CdprError, ExitCode
from cdpr.ui.cli.names import OutPath, again, change_keys, plugin_files
from cdpr.ui.cli.numbers import Real, Whole

if TYPE_CHECKING:
    from cdpr.analysis.study import Results, Study
    from cdpr.analysis.study.spread import Spread
    from cdpr.ui.report.text.study import Figure

TIMEOUT = 3600.0  # s; a hang occupies one worker for this time, and few runs take longer
ROWS = 40  # printed rows of the table


@click.command("study")
@click.argument("study", type=click.Path())
@plugin_files
@change_keys("Change a key in all cases; repeatable.")
@click.option("--jobs", type=Whole(1, 1024), metavar="N", help="Number of parallel cases (default: one per core).")
@click.option(
    "--timeout",
    type=Real(0.0, min_open=True),
    default=TIMEOUT,
    show_default=True,
    metavar="S",
    help="Seconds after which a case counts as hung.",
)
@click.option("--out", type=OutPath(), help="Folder; an unfinished study in it is continued.")
@click.option("--scheduler", metavar="ADDRESS", help="Run on a Dask cluster, such as tcp://host:8786.")
@click.option("--dry-run", is_flag=True, help="Check all cases and list them; run none.")
@click.option("--report/--no-report", default=True, help="Write study.html.")
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
@click.pass_context
def command(
    context: click.Context,
    study: str,
    changes: tuple[str, ...],
    jobs: int | None,
    timeout: float,
    out: str | None,
    scheduler: str | None,
    dry_run: bool,
    report: bool,
    as_json: bool,
) -> None:
    """Run all cases of STUDY, a scenario with any of its keys varied, and tabulate the results.

    Cases that end as infeasible, beyond limits or diverged are results. Ctrl-C keeps the computed results; the same
    command with the same --out continues, and repeats cases that failed, died or hung.
    """
    if jobs is not None and scheduler is not None:
        raise click.UsageError("--jobs does not go with --scheduler: the cluster's workers run a case for each thread")
    if not dry_run and scheduler is None:
        from cdpr.analysis.jobs import forks

        forks.begin()
    from cdpr.analysis.study import load_study
    from cdpr.analysis.study.folder import ended
    from cdpr.analysis.verbs import study as run
    from cdpr.log.run_folder import new_folder
    from cdpr.ui.cli.progress import Progress, terminating

    with terminating():
        with Progress("cases checked") as checked:
            known = ended(Path(out)) if out and not dry_run else {}
            loaded = load_study(study, overrides=changes, progress=checked, ended=known)
        for note in loaded.notes:
            click.echo(note, err=True)
        if dry_run:
            _list(loaded, as_json)
            return
        folder = Path(out) if out else new_folder(loaded.name, "study")
        with Progress("cases") as progress:
            try:
                results = run(
                    loaded,
                    folder,
                    jobs=None if scheduler is not None else jobs or len(os.sched_getaffinity(0)),
                    timeout=timeout,
                    scheduler=scheduler,
                    progress=progress,
                    say=progress.print_line,
                )
            except (KeyboardInterrupt, CdprError) as stop:
                if isinstance(stop, KeyboardInterrupt) or stop.exit_code == ExitCode.BACKEND_DIED:
                    outcome = "interrupted" if isinstance(stop, KeyboardInterrupt) else "stopped"
                    progress.print_line(f"{outcome}; continue by: {again(context, '--out', str(folder))}")
                raise
        if report:
            from cdpr.ui.report.pages.study import write_study

            write_study(results, folder / "study.html")
    if as_json:
        content = {"name": loaded.name, "folder": str(folder), "counts": results.counts}
        spread = {} if results.spread is None else {"spread": results.spread.records()}
        click.echo(json.dumps(content | {"cases": results.table.records()} | spread, indent=1, allow_nan=False))
    else:
        _print(results)
    if results.exit_code:
        raise click.exceptions.Exit(results.exit_code)


def _list(study: Study, as_json: bool) -> None:
    if as_json:
        rows = [{"case": case.id, "block": case.block, **case.labels} for case in study.cases]
        click.echo(json.dumps({"name": study.name, "cases": rows}, indent=1))
        return
    for case in study.cases:
        click.echo(f"{case.id}  {case}")
    click.echo(f"{len(study.cases)} case{'s' * (len(study.cases) != 1)}, all valid")


def _print_spreads(found: Sequence[Spread], figures: Sequence[Figure]) -> None:
    """Print mean and standard deviation over the seeds."""
    from cdpr.ui.report.text.aligned import table
    from cdpr.ui.report.text.study_spread import headings, kinds, labels, row, shown

    if not found:
        return
    axes, drawn, also = list(found[0].labels), shown(found, figures), kinds(found)
    rows = []
    for each in found:
        cells = row(each, drawn, also)
        consistent = [f"{cell.text} ({cell.band})" for cell in cells[len(cells) - len(also) :]]
        rows.append([*labels(each, axes), *(cell.text for cell in cells[: len(cells) - len(also)]), *consistent])
    titles = [*axes, "runs", *(figure.heading for figure in drawn), *headings(also)]
    for line in table([titles, *rows], left=len(axes)):
        click.echo(line)
    band = ", and the 95 % band of a consistent estimator for this number of runs" if also else ""
    click.echo(f"  mean ± standard deviation over the seeds{band}")


def _print(results: Results) -> None:
    """Print the table, or that over the seeds, shortened, and the folder."""
    from cdpr.ui.report.text.aligned import table
    from cdpr.ui.report.text.study import cells, figures_of

    rows = results.table.records()
    spreads = results.spreads
    left, more = ROWS, 0
    for grid in results.study.blocks:
        inside = [row for row in rows if row.get("block") == grid.name]
        if grid.name is not None:
            click.echo(f"{grid.name}: {len(inside)} cases")
        over_seeds = [each for each in spreads if each.block == grid.name]
        if over_seeds:
            _print_spreads(over_seeds[:left], figures_of(inside))
            left, more = max(0, left - len(over_seeds)), more + max(0, len(over_seeds) - left)
            continue
        axes = [leaf.label for axis in grid.axes for leaf in axis.leaves()]
        figures = figures_of(inside)
        shown = [[*labels, *found] for labels, found in (cells(axes, row, figures) for row in inside[:left])]
        if shown:
            headings = [figure.heading for figure in figures]
            for line in table([[*axes, "status", *headings], *shown], left=len(axes) + 1):
                click.echo(line)
        left, more = left - len(shown), more + len(inside) - len(shown)
    if more:
        click.echo(f"  and {more} more")
    click.echo(f"{len(rows)} cases: {results.summary_text}")
    for case in results.study.cases:
        row = results.rows[case.id]
        if row.status in ("failed", "died", "hung"):
            click.echo(f"  {case.id}, {case}: {row.status}: {row.reason}")
    click.echo(results.folder)
