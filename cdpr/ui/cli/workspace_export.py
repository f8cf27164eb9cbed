"""`cdpr workspace export`."""

from __future__ import annotations

from pathlib import Path

import click

from cdpr.ui.cli.names import OutPath


@click.command("export")
@click.argument("file", type=click.Path())
@click.option("--out", type=OutPath(), required=True, help="Output file: .vti, .vtu, .ply or .csv.")
def command(file: str, out: str) -> None:
    """Convert a workspace FILE for other programs.

    NAME.vti is an image of all cells for ParaView, NAME.vtu the boxes proved by certify, NAME.ply the surface as a mesh
    of triangles, NAME.csv a table.
    """
    from cdpr.analysis.workspace.export import export
    from cdpr.analysis.workspace.result import load_workspace

    found = load_workspace(file)
    Path(out).parent.mkdir(parents=True, exist_ok=True)
    export(found, out)
    click.echo(out)
