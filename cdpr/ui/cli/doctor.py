"""`cdpr doctor`."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import ExitCode
from cdpr.ui.cli.names import plugin_files

if TYPE_CHECKING:
    from cdpr.ui.cli.health import Finding

WIDTH = 22  # of names
MARKS = {"ok": " ", "missing": "-", "wrong": "!"}


@click.command("doctor")
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(as_json: bool) -> None:
    """Check the installation, and show what to install; without network access.

    Missing packages are marked -, installed ones with errors !. The exit code is 3 if a library or a plugin does not
    work, else 8 if a folder cannot be written, else 0: missing extras are not an error.
    """
    from cdpr.ui.cli.health import examine

    found: list[Finding] = []
    for one in examine():
        if not as_json:  # printed at once: if a library ends the process, the last line shows which
            _print(one, fresh=not found or found[-1].group != one.group)
        found.append(one)
    wrong = [one for one in found if one.state == "wrong"]
    remedies = list(dict.fromkeys(one.remedy for one in found if one.state != "ok" and one.remedy))
    if as_json:
        click.echo(
            json.dumps({"ok": not wrong, "found": [asdict(one) for one in found], "remedies": remedies}, indent=2)
        )
    else:
        click.echo(f"{len(wrong)} do not work" if wrong else "all that is installed works")
    if wrong:
        unwritable = all(one.group == "folders" for one in wrong)
        raise click.exceptions.Exit(ExitCode.NOT_WRITABLE if unwritable else ExitCode.PLUGIN)


def _print(one: Finding, *, fresh: bool) -> None:
    if fresh:
        click.echo(one.group)
    remedy = f": {one.remedy}" if one.state != "ok" and one.remedy else ""
    click.echo(f"{MARKS[one.state]} {one.name:<{WIDTH}}  {one.text}{remedy}")
