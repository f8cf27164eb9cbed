"""`cdpr workspace plot`."""

from __future__ import annotations

import math
from pathlib import Path

import click

from cdpr.base.errors import OutputError
from cdpr.ui.cli.names import OutPath, force_option
from cdpr.ui.cli.numbers import number


@click.command("plot")
@click.argument("file", type=click.Path())
@click.option("--slice", "slices", multiple=True, metavar="AXIS=M", help="Slice, such as z=1.0; repeatable. [three]")
@click.option("--out", type=OutPath(), help="Output page, .html. [beside FILE]")
@force_option
def command(file: str, slices: tuple[str, ...], out: str | None, force: bool) -> None:
    """Draw a workspace FILE on a page: with its robot in space, which can be rotated, and slices through it.

    The page is self-contained.
    """
    from cdpr.analysis.workspace.result import load_workspace
    from cdpr.log.files import make_folder, replace_markup, require_new
    from cdpr.ui.cli.workspace_compare import robot_of
    from cdpr.ui.report.pages.workspace import render_workspace

    found = load_workspace(file)
    target = Path(file).with_suffix(".html") if out is None else Path(out)
    if target.suffix != ".html" or target.is_dir():
        raise OutputError(f"{target}: --out: expected the name of a page that ends in .html")
    require_new(target, force)
    text = render_workspace(found, robot_of(found, file), [_slice(each) for each in slices])
    make_folder(target.parent)
    replace_markup(target, text, force)
    click.echo(str(target))


def _slice(text: str) -> tuple[int, float]:
    name, _, place = text.partition("=")
    try:
        if name not in ("x", "y", "z"):
            raise ValueError
        at = number(place)
        if not math.isfinite(at):
            raise ValueError
        return "xyz".index(name), at
    except ValueError:
        raise click.BadParameter(
            f"expected an axis and a position (m), such as z=1.0, got {text[:80]!r}", param_hint="--slice"
        ) from None
