"""`cdpr examples`."""

from __future__ import annotations

import json

import click

ROLES = {
    "scenario": "scenarios: cdpr run NAME",
    "robot": "robots: cdpr info NAME",
    "study": "studies: cdpr study NAME",
    "design": "designs: cdpr design NAME",
}


@click.group("examples", invoke_without_command=True)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def command(context: click.Context, as_json: bool) -> None:
    """List the examples of cdpr; all commands accept their names in place of files."""
    if context.invoked_subcommand is not None:
        return
    from cdpr.scenario.examples import examples

    found = examples()
    if as_json:
        rows = [{"name": one.name, "kind": one.kind, "shows": one.shows, "file": str(one.path)} for one in found]
        click.echo(json.dumps(rows, indent=2))
        return
    from cdpr.ui.report.text.aligned import table

    for kind, title in ROLES.items():
        click.echo(title)
        for line in table([(one.name, one.shows) for one in found if one.kind == kind], left=2):
            click.echo(line)


@command.command("copy")
@click.argument("name")
@click.option(
    "--to", default=".", show_default=True, type=click.Path(), help="Folder to copy into; created if necessary."
)
def copy(name: str, to: str) -> None:
    """Copy the example NAME, with its robots, for editing."""
    from pathlib import Path

    from cdpr.scenario import examples

    for path in examples.copy(name, Path(to)):
        click.echo(path)
