"""`cdpr repair`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from cdpr.log.repair import RepairReport


@click.command("repair")
@click.argument("run", type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(run: str, as_json: bool) -> None:
    """Repair the log of a killed run.

    RUN is the folder of a run, or a log. The rows up to the first damage are kept, and the rest is saved as
    log.mcap.torn. An intact log is not changed. Missing images of cameras are rendered from the rows.
    """
    from cdpr.log.repair import repair

    report = repair(run)
    images = _images(report) if report.rows else None
    if as_json:
        click.echo(
            json.dumps(
                {
                    "log": str(report.log),
                    "rows": report.rows,
                    "problem": report.problem,
                    "torn": None if report.torn is None else str(report.torn),
                    "lost_bytes": report.lost,
                    "interrupted": report.interrupted,
                    "images": None if images is None else str(images),
                },
                indent=2,
            )
        )
        return
    if report.problem is None:
        what = f"complete, {report.rows} rows" if report.log.exists() else "the run ended before its first sample"
        click.echo(f"{report.log}: {what}")
    else:
        click.echo(f"{report.log}: was {report.problem}; complete now, with {report.rows} rows")
        if report.torn is not None:
            click.echo(f"the rest of the log is stored as {report.torn}")
        if report.lost:
            click.echo(f"no disk space to keep the {report.lost} bytes of an incomplete block")
    if report.interrupted:
        click.echo('run.json: status "running" changed to "interrupted"')
    if images is not None:
        click.echo(f"{images}: rendered")


def _images(report: RepairReport) -> Path | None:
    """Render missing images into the folder of the run; return their file if it was written."""
    from cdpr.base.errors import CdprError
    from cdpr.log.reader import load_run

    repaired = load_run(str(report.log))
    if not repaired.header.imaging:
        return None
    from cdpr.log.image_file import complete_images  # few runs need this import

    try:
        return complete_images(repaired)
    except CdprError as error:
        click.echo(f"warning: the images of cameras are not rendered: {error}", err=True)
        return None
