"""`cdpr workspace combine`."""

from __future__ import annotations

import click

from cdpr.ui.cli.names import OutPath, force_option


@click.command("combine")
@click.argument("first", type=click.Path())
@click.argument("how", metavar="and|or|minus", type=click.Choice(["and", "or", "minus"]))
@click.argument("second", type=click.Path())
@click.option("--out", type=OutPath(), help="File, .npz.")
@force_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(first: str, how: str, second: str, out: str | None, force: bool, as_json: bool) -> None:
    """Combine the workspaces FIRST and SECOND, which have the same cells and attitudes.

    The result contains the cells in both (and), in at least one (or), or only in the first (minus).
    """
    from cdpr.analysis.workspace.combine import combine
    from cdpr.analysis.workspace.result import load_workspace
    from cdpr.ui.cli.workspace_kind import finish, target_of

    target = target_of(out, force)
    finish(combine(load_workspace(first), how, load_workspace(second)), target, force, as_json)
