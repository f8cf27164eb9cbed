"""`cdpr gui`."""

from __future__ import annotations

import gc
from functools import partial
from typing import TYPE_CHECKING

import click

from cdpr.base.errors import PluginError
from cdpr.ui.cli.names import change_keys, plugin_files, plugin_option
from cdpr.ui.cli.numbers import Whole

if TYPE_CHECKING:
    from cdpr.ui.cli.progress import Signals

USUAL = (700, 10, 10)  # Python's default thresholds of garbage collection
LOST = 1.0  # s until an interrupt that Python has lost is noticed
LOCAL = ("127.0.0.1", "localhost", "::1")
EXPOSED = (
    "warning: anyone with this address and its token can run simulations here, with the plugins that are "
    "installed, and read and write files as you can; it is not encrypted"
)


@click.command("gui")
@click.argument("file", required=False, type=click.Path())
@plugin_option("--backend", "backend", metavar="NAME", help="Physics backend, instead of the scenario's.")
@plugin_option("--solver", "solver", metavar="NAME", help="Tension solver, instead of the scenario's.")
@plugin_option("--controller", "controller", metavar="NAME", help="Controller, instead of the scenario's.")
@plugin_option("--estimator", "estimator", metavar="NAME", help="Estimator of the state, instead of the scenario's.")
@change_keys("Change a key of the scenario; repeatable.")
@plugin_files
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option("--port", type=Whole(0, 65535), help="Port to listen on (default: the first free from 8080).")
@click.option("--open/--no-open", "show", default=True, help="Open the window in the browser.")
def command(
    file: str | None,
    backend: str | None,
    solver: str | None,
    controller: str | None,
    estimator: str | None,
    changes: tuple[str, ...],
    host: str,
    port: int | None,
    show: bool,
) -> None:
    """Open a window that shows and edits a robot or a scenario, runs it and steers the run.

    FILE is a scenario, a robot, or the name of an example; default: the example caroca. The window is a page in the
    browser; its address, with the access token, is printed. Ctrl-C ends it.
    """
    from cdpr.ui.cli.progress import terminating

    with terminating() as signals:
        try:
            from cdpr.ui.gui.window import Window
        except ModuleNotFoundError as error:
            if (error.name or "").partition(".")[0] != "websockets":
                raise
            raise PluginError("cdpr gui needs websockets, not installed: pip install 'cdpr[gui]'") from None
        from threading import Thread

        gc.set_threshold(*USUAL)  # long-lived process with many temporary objects
        from cdpr.scenario.choices import typed
        from cdpr.ui.gui.editor import Editor

        chosen = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
        editor = Editor(file, typed(chosen, changes))
        with Window(editor, partial(click.echo, err=True), host, port) as window:
            click.echo(window.address)
            if host not in LOCAL:
                click.echo(EXPOSED, err=True)
            if show:
                Thread(target=_open, args=(window.address,), daemon=True).start()  # some browsers start slowly
            window.begin()
            _hold(signals)


def _hold(signals: Signals) -> None:
    """Wait until the command is ended.

    Python loses an interrupt that arrives where exceptions cannot propagate, such as at the end of an import.
    """
    from threading import Event

    while not signals.pending:
        Event().wait(LOST)
    raise KeyboardInterrupt


def _open(address: str) -> None:
    import webbrowser

    if not webbrowser.open(address):
        click.echo("no browser could be opened: open the address by hand", err=True)
