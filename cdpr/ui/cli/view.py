"""`cdpr view`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import CdprError, OutputError
from cdpr.ui.cli.names import OutPath, change_keys, force_option, names, plugin_files

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

PAGE = "view.html"
FIGURES = {".pdf": b"%PDF-1.4\n%\xac\xdc", ".svg": b"<?xml", ".png": b"\x89PNG"}  # first bytes of Matplotlib's files


@click.command("view")
@click.argument("what", metavar="RUN [RUN...] | ROBOT | SCENARIO", nargs=-1, required=True, type=click.Path())
@click.option(
    "--pose",
    metavar="X,Y,Z[,R,P,Y]",
    help="Pose of a robot: position (m) and roll, pitch, yaw (rad, or as 30deg).",
)
@change_keys("Change any key of the file.")
@plugin_files
@click.option(
    "--figure",
    metavar="NAME[,NAME]",
    help="For a run: write a figure of these quantities (tension, position_error, ...) instead of the page; requires "
    "--out FILE.pdf, .svg or .png.",
)
@click.option(
    "--width", metavar="WIDTH", help="Width of the figure: ieee (the default), ieee-wide or a length such as '88 mm'."
)
@click.option("--cables", metavar="A,B", help="Names or numbers of the cables in the figure.")
@click.option("--out", type=OutPath(), help="File for the page (default: view.html in the user's cache, overwritten).")
@force_option
@click.option("--open/--no-open", "show", default=True, help="Open the page in the browser.")
def command(
    what: tuple[str, ...],
    pose: str | None,
    changes: tuple[str, ...],
    figure: str | None,
    width: str | None,
    cables: str | None,
    out: str | None,
    force: bool,
    show: bool,
) -> None:
    """Write a page that shows a run, several runs, a robot or a scenario's motion in space, and open it.

    A run is animated with all recorded quantities; several are superimposed, with their differences; a scenario's
    desired motion is shown without a simulation. The page is self-contained.
    """
    from cdpr.log.files import replace_markup

    if figure is not None:
        _figure(what, pose, changes, (figure, width, cables), out, force)
        return
    if width is not None or cables is not None:
        raise click.UsageError("--width and --cables are of a figure: give --figure, too")
    path = None if out is None else _page_at(Path(out), force)
    page = _runs(what, pose, changes) if _are_runs(what) else _view_page(what, pose, changes)
    path = path or _usual()
    replace_markup(path, page, force or out is None)
    click.echo(path)
    if show:
        import webbrowser

        if not webbrowser.open(path.resolve().as_uri()):
            click.echo("no browser could be opened: open the page by hand", err=True)


def _figure(
    what: tuple[str, ...],
    pose: str | None,
    changes: tuple[str, ...],
    options: tuple[str, str | None, str | None],
    out: str | None,
    force: bool,
) -> None:
    """Plot quantities of a run into a file."""
    from io import BytesIO

    from cdpr.log.files import replace
    from cdpr.log.reader import load_run
    from cdpr.ui.report.style import DRAWN_BY

    figure, width, cables = options
    if not names(figure):
        raise click.UsageError("--figure: expected a quantity, such as tension, got none")
    if out is None or Path(out).suffix.lower() not in FIGURES:
        raise click.UsageError(f"--figure needs a file to write: --out NAME with {', '.join(FIGURES)} at its end")
    if len(what) > 1 or not _are_runs(what) or pose is not None or changes:
        raise click.UsageError("--figure needs one finished run: give its folder or log, without --set or --pose")
    path, kind = Path(out), Path(out).suffix.lower()
    _only_over(
        path,
        lambda content: content.startswith(FIGURES[kind]) and DRAWN_BY.encode() in content,
        f"figure in {kind[1:].upper()} that cdpr drew",
        force,
    )
    shown = None if cables is None else names(cables)
    drawn = load_run(what[0]).plot(*names(figure), cables=shown, width="ieee" if width is None else width)
    file = BytesIO()
    drawn.savefig(file, format=kind[1:])
    replace(path, file.getvalue(), force)
    click.echo(path)


def _page_at(path: Path, force: bool) -> Path:
    """Return the path of a page."""
    from cdpr.ui.report.pages.page import is_page

    path = path / PAGE if path.is_dir() else path
    _only_over(path, is_page, "page that cdpr wrote", force)
    return path


def _only_over(path: Path, ours: Callable[[bytes], bool], what: str, force: bool) -> None:
    """Raise OutputError if the file exists without `force`, or was not written by cdpr."""
    from cdpr.log.files import require_new

    if path.exists() and not (path.is_file() and ours(path.read_bytes())):
        raise OutputError(f"'{path}' already exists and is not a {what}: it is not overwritten; choose another name")
    require_new(path, force)


def _are_runs(what: Sequence[str]) -> bool:
    """Return True for folders or logs of runs, False for a single robot, scenario or example."""
    from cdpr.scenario.examples import is_run

    others = [name for name in what if not is_run(name)]
    if others and len(what) > 1:
        named = ", ".join(map(click.format_filename, others))
        raise CdprError(
            f"{named}: not the folder or log of a run; several arguments are runs (folders or .mcap files) that are "
            "laid over one another: give robots and scenarios one at a time"
        )
    return not others


def _runs(what: tuple[str, ...], pose: str | None, changes: tuple[str, ...]) -> str:
    if pose is not None or changes:
        raise CdprError("finished runs cannot be changed: leave out --pose and --set")
    from cdpr.log.reader import load_run
    from cdpr.ui.report.view import page_of_runs

    return page_of_runs(what if len(what) > 1 else load_run(what[0]))


def _view_page(what: tuple[str, ...], pose: str | None, changes: tuple[str, ...]) -> str:
    from cdpr.ui.cli.load import load_with_warnings

    loaded = load_with_warnings(what[0], changes)
    # imported only after the file is valid, because it is slow
    from cdpr.ui.cli.pose_option import pose_and_gravity
    from cdpr.ui.report.view import page_of

    return page_of(loaded, *pose_and_gravity(loaded, pose)[1:])


def _usual() -> Path:
    """Return the path of temporary pages: always the same, so that they do not accumulate."""
    from cdpr.base.user_folders import user_cache
    from cdpr.log.files import unwritable

    path = user_cache() / PAGE
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(path, error) from error
    return path
