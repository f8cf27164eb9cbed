"""`cdpr workspace export`."""

from __future__ import annotations

from pathlib import Path

import click

from cdpr.ui.cli.names import OutPath, force_option


@click.command("export")
@click.argument("file", type=click.Path())
@click.option("--out", type=OutPath(), required=True, help="Output file: .vti, .vtu, .ply or .csv.")
@force_option
def command(file: str, out: str, force: bool) -> None:
    """Convert a workspace FILE for other programs.

    NAME.vti is an image of all cells for ParaView, NAME.vtu the boxes proved by certify, NAME.ply the surface as a mesh
    of triangles, NAME.csv a table.
    """
    from cdpr.analysis.workspace.export import export
    from cdpr.analysis.workspace.result import load_workspace
    from cdpr.log.files import make_folder, require_new

    require_new(Path(out), force)
    found = load_workspace(file)
    make_folder(Path(out).parent)
    export(found, out, force)
    click.echo(out)
