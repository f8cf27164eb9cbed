"""`cdpr compare`."""

from __future__ import annotations

import json

import click

from cdpr.base.errors import CdprError, ExitCode
from cdpr.ui.cli.load import strict_option
from cdpr.ui.cli.names import OutPath, change_keys, names, plugin_files, plugin_option
from cdpr.ui.cli.numbers import Real, Whole
from cdpr.ui.cli.progress import Progress, terminating


@click.command("compare")
@click.argument("what", metavar="SCENARIO | RUN RUN...", nargs=-1, required=True, type=click.Path())
@plugin_option(
    "--backends", "backend", default="all", show_default=True, metavar="A,B|all", help="Names of the engines."
)
@plugin_option("--solvers", "solver", metavar="A,B", help="Tension solvers, instead of the scenario's.")
@change_keys("Change a key of the scenario; repeatable.")
@plugin_files
@strict_option
@click.option("--refine", is_flag=True, help="Measure the order of each engine with three physics steps.")
@click.option("--jobs", type=Whole(1), help="Number of parallel processes (default: one per core).")
@click.option("--timeout", type=Real(1.0), help="Time limit of a run, s (default: none).")
@click.option("--out", type=OutPath(), help="Folder for compare.json, compare.html and the runs.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    what: tuple[str, ...],
    backends: str,
    solvers: str | None,
    changes: tuple[str, ...],
    strict: bool,
    refine: bool,
    jobs: int | None,
    timeout: float | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Run SCENARIO in closed loop on several engines, or compare finished RUNs.

    The reference is the engine of highest order. An engine with the same scheme must agree with it except for
    round-off; for any other engine the difference must shrink with the step as its order predicts. The exit code is 7
    if an engine disagrees or no comparison was possible, and 0 if the engines agree.
    """
    from pathlib import Path

    from cdpr.scenario.examples import is_run

    finished = len(what) > 1 or is_run(what[0])
    if finished and (changes or refine or solvers or strict or backends != "all"):
        options = "--backends, --solvers, --set, --strict and --refine"
        raise CdprError(f"finished runs cannot be changed: leave out {options}")
    if finished:
        for name in what:
            if name.endswith((".yaml", ".yml")):
                raise CdprError(f"{name}: is not a run: give either one SCENARIO, or only folders of finished runs")
        from cdpr.analysis.compare.job import RESERVED
        from cdpr.analysis.verbs import compare
        from cdpr.log.run_folder import claim

        result = compare(what)
        if out is not None:
            claim(Path(out), RESERVED)
    else:
        from cdpr.analysis.jobs import forks

        forks.begin()
        from cdpr.analysis.verbs import compare

        counted = (0, 0)

        def count(done: int, total: int) -> None:
            nonlocal counted
            counted = (done, total)
            progress(done, total)

        with terminating(), Progress("runs") as progress:
            try:
                result = compare(
                    what[0],
                    overrides=changes,
                    strict=strict,
                    backends=None if backends == "all" else names(backends),
                    solvers=None if solvers is None else names(solvers),
                    refine=refine,
                    out=None if out is None else Path(out),
                    jobs=jobs,
                    timeout=timeout,
                    progress=count,
                    say=progress.print_line,
                )
            except KeyboardInterrupt:
                free = "" if out is None else f", and {out} can be used again"
                progress.print_line(
                    f"interrupted after {counted[0]} of {counted[1]} runs: no result of the comparison is stored{free}"
                )
                raise
    if out is not None:
        from cdpr.ui.report.pages.compare import write_comparison

        write_comparison(result, Path(out))
    if as_json:
        click.echo(json.dumps(result.figures, indent=1, allow_nan=False))
    else:
        from cdpr.ui.report.text.compare import lines

        for line in lines(result.figures):
            click.echo(line)
        if out is not None:
            click.echo(out)
    if result.figures["agrees"] is not True:
        raise click.exceptions.Exit(ExitCode.DISAGREES)
