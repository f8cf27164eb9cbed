"""`cdpr design`."""

from __future__ import annotations

import json
import os
from pathlib import Path

import click

from cdpr.ui.cli.names import OutPath, again, plugin_files
from cdpr.ui.cli.numbers import Whole


@click.command("design")
@click.argument("study", type=click.Path())
@click.option("--out", type=OutPath(), help="Folder.")
@click.option("--jobs", type=Whole(1, 1024), metavar="N", help="Number of parallel candidates (default: one per core).")
@click.option("--resume", is_flag=True, help="Continue the design in the folder of --out.")
@click.option(
    "--evaluations", type=Whole(1, 10_000_000), metavar="N", help="Number of candidates (default: that of the study)."
)
@click.option("--report/--no-report", default=True, help="Write report.html.")
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def command(
    context: click.Context,
    study: str,
    out: str | None,
    jobs: int | None,
    resume: bool,
    evaluations: int | None,
    report: bool,
    as_json: bool,
) -> None:
    """Search for the best robot of STUDY: keys of a robot file, varied within bounds, goals and constraints.

    The folder contains the best robot (best.yaml), for several goals all that no other dominates (front), every
    evaluation (evaluations.csv), figures before and after (design.json) and a page. Ctrl-C keeps the evaluations so
    far. The exit code is 4 if no candidate satisfies all constraints.
    """
    if resume and out is None:
        raise click.UsageError("--resume requires --out, the folder to continue")
    from cdpr.analysis.design import load_design
    from cdpr.analysis.verbs import design as run
    from cdpr.log.run_folder import new_folder
    from cdpr.ui.cli.progress import Progress, terminating
    from cdpr.ui.report.text.design import lines

    with terminating():
        loaded = load_design(study, evaluations=evaluations)
        folder = Path(out) if out else new_folder(loaded.name, "design")
        with Progress("candidates") as progress:
            try:
                found = run(
                    loaded,
                    folder,
                    jobs=jobs or len(os.sched_getaffinity(0)),
                    resume=resume,
                    progress=progress,
                )
            except KeyboardInterrupt:
                more = () if resume else ("--resume",)
                progress.print_line(f"interrupted; continue by: {again(context, '--out', str(folder), *more)}")
                raise
        if report:
            from cdpr.ui.report.pages.design import write_design

            write_design(found, folder / "report.html")
    if as_json:
        click.echo(json.dumps(found.to_dict() | {"folder": str(folder)}, indent=1, allow_nan=False))
    else:
        for line in lines(found.to_dict()):
            click.echo(line)
        click.echo(str(folder))
    if found.exit_code:
        raise click.exceptions.Exit(found.exit_code)
