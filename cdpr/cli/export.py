"""`cdpr export`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from cdpr.cli.names import OutPath


@click.command("export")
@click.argument("run", type=click.Path())
@click.option(
    "--to",
    type=click.Choice(["csv", "npz", "mat", "parquet"]),
    required=True,
    help="Format; mat and parquet need the extra `data`.",
)
@click.option("--out", type=OutPath(path_type=Path), help="File; default: run.FORMAT beside the log.")
@click.option("--force", is_flag=True, help="Replace the file if it exists.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(run: str, to: str, out: Path | None, force: bool, as_json: bool) -> None:
    """Convert a run to CSV, NumPy, MATLAB or Parquet.

    RUN is the folder of a run, or a log.
    """
    from cdpr.log.export import export
    from cdpr.log.reader import load_run, locate

    log, _ = locate(run)
    out = out or log.with_name(f"run.{to}")
    loaded = load_run(run)
    export(loaded, to, out, force)
    if as_json:
        click.echo(json.dumps({"file": str(out), "format": to, "rows": len(loaded.rows)}))
    else:
        click.echo(f"{out}: {len(loaded.rows)} rows")
