"""`cdpr fmu info`."""

from __future__ import annotations

import json

import click


@click.command("info")
@click.argument("file", type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: str, as_json: bool) -> None:
    """Show the metadata of the FMU in FILE; its native code is not loaded."""
    from cdpr.fmu.read.archive import open_archive
    from cdpr.fmu.read.describe import describe
    from cdpr.ui.report.text.fmu import lines

    figures = describe(open_archive(file))
    if as_json:
        click.echo(json.dumps(figures, indent=2))
    else:
        for line in lines(figures):
            click.echo(line)
