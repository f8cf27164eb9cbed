"""`cdpr size`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from cdpr.base.defaults import SAFETY
from cdpr.base.errors import OutputError
from cdpr.scenario.examples import is_run
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files
from cdpr.ui.cli.numbers import Real


@click.command("size")
@click.argument("what", metavar="SCENARIO...|RUN...", nargs=-1, required=True, type=click.Path())
@change_keys("Change any key of the scenarios.")
@click.option(
    "--safety",
    type=Real(1.0),
    default=SAFETY,
    show_default=True,
    metavar="N",
    help="Ratio of breaking load to largest tension.",
)
@click.option("--broken", is_flag=True, help="Repeat the analysis with each cable broken in turn.")
@click.option(
    "--wrench-box",
    "box",
    metavar="FX,FY,FZ,MX,MY,MZ",
    help="Add these wrenches at rest, all over the workspace, in addition to the weight: half widths (N, N m).",
)
@click.option("--lower", metavar="X,Y,Z", help="Lowest corner of that workspace, m. [the frame's]")
@click.option("--upper", metavar="X,Y,Z", help="Highest corner, m.")
@click.option("--cells", metavar="N|NX,NY,NZ", help="Cells along the longest side, or along each side. [10]")
@click.option("--out", type=OutPath(), help="Output page, .html, which prints on one sheet.")
@force_option
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    what: tuple[str, ...],
    changes: tuple[str, ...],
    safety: float,
    broken: bool,
    box: str | None,
    lower: str | None,
    upper: str | None,
    cells: str | None,
    out: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Size cables, drums and motors for several scenarios and runs.

    A scenario's motion is evaluated by inverse kinematics and dynamics, with tensions of minimum 2-norm; of a run the
    recorded values are used. The power of a cable is that on the platform; a motor's power includes inertia and
    friction of the drum.
    """
    from cdpr.ui.cli.progress import Progress

    if box is None and not lower is upper is cells is None:
        raise click.UsageError("--lower, --upper and --cells require --wrench-box")
    target = None if out is None else Path(out)
    if target is not None and (target.suffix != ".html" or target.is_dir()):
        raise OutputError(f"{target}: --out: expected the name of a page that ends in .html")
    if target is not None:
        from cdpr.log.files import require_new

        require_new(target, force)
    if changes and (runs := [each for each in what if is_run(each)]):
        raise click.UsageError(f"--set applies to scenarios, and {runs[0]} is a run")
    from cdpr.analysis.verbs import size
    from cdpr.ui.report.text.sizing import lines

    with Progress("load cases") as progress:
        found = size(
            what,
            safety=safety,
            broken=broken,
            progress=progress,
            overrides=changes,
            say=progress.print_line,
            **_wrenches(box, lower, upper, cells),
        )
    figures = found.to_dict()
    if target is not None:
        from cdpr.log.files import make_folder, replace_markup
        from cdpr.ui.report.pages.sizing import render_sizing

        make_folder(target.parent)
        replace_markup(target, render_sizing(figures), force)
    if as_json:
        click.echo(json.dumps(figures, indent=1, allow_nan=False))
        return
    for line in lines(figures):
        click.echo(line)
    if target is not None:
        click.echo(str(target))


def _wrenches(box: str | None, lower: str | None, upper: str | None, cells: str | None) -> dict[str, Any]:
    """Return the arguments of `cdpr.size` for --wrench-box."""
    if box is None:
        return {}
    from cdpr.analysis.workspace import box as box_of
    from cdpr.ui.cli.workspace_kind import cells_of, numbers_of

    low, high = (
        None if text is None else numbers_of(text, (3,), name)
        for text, name in ((lower, "--lower"), (upper, "--upper"))
    )
    required = box_of(numbers_of(box, (6,), "--wrench-box"))
    return {"required": required, "lower": low, "upper": high, "cells": cells_of(cells)}
