"""Main object of the GUI, which connects editor, simulation and browser windows."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import partial
from threading import Lock
from typing import Any, Self

from cdpr.base.errors import CdprError, one_line
from cdpr.scenario.scenario import Scenario
from cdpr.simulation.arguments import call
from cdpr.simulation.requests import Level
from cdpr.ui.gui.broadcast import Broadcast, Reader
from cdpr.ui.gui.driver import WindowDriver
from cdpr.ui.gui.editor import Editor
from cdpr.ui.gui.exchange import Exchange
from cdpr.ui.gui.scratch import sweep
from cdpr.ui.gui.server import Server, Words, notice

Log = Callable[[str], None]


class Window:
    """Scenario that is edited, simulated and shown in any number of browser windows.

    Args:
        editor: editor of the files.
        log: receives text that only the terminal shows.
        host: address or name to listen on.
        port: port; defaults to the first free one.

    Raises:
        CdprError: if it cannot listen there.
    """

    def __init__(self, editor: Editor, log: Log, host: str = "127.0.0.1", port: int | None = None) -> None:
        self._editor, self._log, self._lock = editor, log, Lock()
        self._broadcast = Broadcast()
        self._driver = WindowDriver(self._broadcast, log)
        self._exchange = Exchange(self._scenario, self._open, log)
        self._doing: dict[str, Callable[..., Any]] = {
            "edit": editor.edit,
            "remove": editor.remove,
            "insert": editor.insert,
            "undo": editor.undo,
            "redo": editor.redo,
            "revert": editor.revert,
            "apply": self._apply,
            "save": editor.save,
            "save_as": lambda file: editor.save_as(file),  # parameter names are those of the messages
            "open": lambda name: self._other(editor.open, name),
            "new": lambda kind, **arguments: self._other(editor.new, kind, **arguments),
            "yaml": editor.texts,
        }
        try:
            self._server = Server(_page, self._broadcast, self.receive, host, port)
        except BaseException:
            self._exchange.close()
            self._driver.close()
            raise

    @property
    def address(self) -> str:
        """Address to open in a browser."""
        return self._server.address

    def begin(self) -> None:
        """Show the form, and simulate its scenario if it is valid."""
        from cdpr.ui.gui.page import hello

        sweep()
        self._broadcast.put({"kind": "hello", **hello()})
        with self._lock:
            go_on = self._begin()
            self._put_form()
            go_on()

    def receive(self, words: Words, reader: Reader) -> None:
        """Execute a message of a window; errors are reported to that window."""
        do = words.pop("do")

        def reply(level: Level, text: str) -> None:
            reader.send(notice(level, text))

        if do in self._exchange.does:
            self._exchange.begin(do, words, reader)
            return
        if do not in self._doing:
            self._driver.command(do, words, reply)
            return
        try:
            self._edit(do, words, reader)
        except CdprError as error:
            reply("error", str(error))
        except Exception as error:
            self._log(traceback.format_exc())
            reply("error", f"internal error: {one_line(error)}; the terminal has more")

    def _edit(self, do: str, words: Words, reader: Reader) -> None:
        """Execute an editor command and send the form to all windows."""
        with self._lock:
            try:
                done = call(do, self._doing[do], words)
            finally:
                self._put_form()
            if callable(done):  # start after the form that it belongs to is sent
                done()
        if do == "yaml":
            reader.send({"kind": "yaml", "files": done})
        elif do in ("save", "save_as"):
            reader.send(notice("info", f"saved: {', '.join(map(str, done))}"))

    def _apply(self) -> Callable[[], None]:
        """Return a function that starts the scenario of the form."""
        try:
            scenario = self._editor.apply()
        except CdprError as error:
            raise _in_short("not applied", error) from error
        return partial(self._driver.load, scenario)

    def _scenario(self) -> Scenario:
        """Return the scenario of the form, for export."""
        with self._lock:
            try:
                return self._editor.scenario()
            except CdprError as error:
                raise _in_short("not exported", error) from error

    def _open(self, name: str, reader: Reader) -> None:
        """Open imported files."""
        self._edit("open", {"name": name}, reader)

    def _other(self, change: Callable[..., Any], /, *names: Any, **arguments: Any) -> Callable[[], None]:
        """Open other files and return a function that starts them."""
        change(*names, **arguments)
        return self._begin()

    def _begin(self) -> Callable[[], None]:
        """Return a function that starts the scenario of the form, or one that shows no simulation if it is invalid."""
        try:
            return self._apply()
        except CdprError:
            return self._driver.nothing

    def _put_form(self) -> None:
        self._broadcast.put(self._editor.form())

    def close(self) -> None:
        """Close everything."""
        self._server.close()
        self._exchange.close()
        self._driver.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _in_short(what: str, error: CdprError) -> CdprError:
    """Return an error with the first problem of a form and the number of problems."""
    first, count = str(error).partition("\n")[0], len(error.rows)
    return CdprError(f"{what}: {f'{count} problems, the first: ' if count > 1 else ''}{first}")


def _page() -> str:
    """Return the page; its modules are imported when the first browser connects."""
    from cdpr.ui.gui.page import document

    return document()
