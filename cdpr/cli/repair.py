"""`cdpr repair`."""

from __future__ import annotations

import json

import click


@click.command("repair")
@click.argument("run", type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(run: str, as_json: bool) -> None:
    """Make the log of a killed run whole again.

    RUN is the folder of a run, or a log. The rows up to the first damage are kept, the old log too, as
    log.mcap.torn. Where nothing is wrong, nothing is done.
    """
    from cdpr.log.repair import repair

    report = repair(run)
    if as_json:
        click.echo(
            json.dumps(
                {
                    "log": str(report.log),
                    "rows": report.rows,
                    "problem": report.problem,
                    "torn": None if report.torn is None else str(report.torn),
                    "interrupted": report.interrupted,
                },
                indent=2,
            )
        )
        return
    if report.torn is None:
        click.echo(f"{report.log}: complete, {report.rows} rows")
    else:
        click.echo(f"{report.log}: was {report.problem}; written anew with {report.rows} rows")
        click.echo(f"the old one is kept as {report.torn}")
    if report.interrupted:
        click.echo('run.json said "running", now "interrupted"')
