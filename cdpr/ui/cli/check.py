"""`cdpr check`."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import ExitCode
from cdpr.base.redirect_output import redirect_output
from cdpr.ui.cli.names import plugin_files
from cdpr.ui.cli.progress import Progress

if TYPE_CHECKING:
    from cdpr.plugins.registry import Role


@click.command("check")
@click.argument("role", type=click.Choice(["backend", "solver", "controller", "estimator"]))
@click.argument("name")
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(role: Role, name: str, as_json: bool) -> None:
    """Check an installed plugin against the rules of its role.

    The exit code is 7 if any check fails. Times are shown but not judged. A plugin that never returns has no time
    limit: end the command with Ctrl-C, which shows the running check.
    """
    from cdpr.testing import check_plugin
    from cdpr.ui.report.text.aligned import table

    running = ""

    def begin(check: str) -> None:
        nonlocal running
        running = check
        display.show(check)  # remains if the plugin ends the process

    try:
        with redirect_output(), Progress() as display:
            results = check_plugin(role, name, begin)
    except KeyboardInterrupt:
        if running:
            click.echo(f"interrupted in the check {running}", err=True)
        raise
    if as_json:
        rows = [dataclasses.asdict(result) for result in results]
        click.echo(json.dumps({"role": role, "name": name, "checks": rows}, indent=2))
    else:
        lines = [
            (one.outcome, one.id, f"{one.seconds:5.2f} s", one.reason if one.outcome == "passed" else one.detail)
            for one in results
        ]
        for line in table(lines, left=4, indent=""):
            click.echo(line)
        counts = Counter(result.outcome for result in results)
        click.echo(f"{role} '{name}': " + ", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    if any(result.outcome == "failed" for result in results):
        raise click.exceptions.Exit(ExitCode.DISAGREES)
