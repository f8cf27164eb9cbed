"""The window: joins what is edited, what runs, and who looks on."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import partial
from threading import Lock
from types import TracebackType
from typing import Any, Self

from cdpr.errors import CdprError, one_line
from cdpr.gui.arguments import call
from cdpr.gui.board import Board, Reader
from cdpr.gui.desk import Desk
from cdpr.gui.exchange import Exchange
from cdpr.gui.scratch import sweep
from cdpr.gui.server import Server, Words, said
from cdpr.gui.show import Level, Show
from cdpr.scenario.scenario import Scenario

Log = Callable[[str], None]


class Window:
    """A scenario that is edited, simulated and shown, in as many windows of browsers as are opened.

    Args:
        desk: the files.
        log: takes what only the terminal should have.
        host: where to listen.
        port: likewise; the first that is free unless given.

    Raises CdprError where it cannot listen there.
    """

    def __init__(self, desk: Desk, log: Log, host: str = "127.0.0.1", port: int | None = None) -> None:
        self._desk, self._log, self._lock = desk, log, Lock()
        self._board = Board()
        self._show = Show(self._board, log)
        self._exchange = Exchange(self._scenario, self._open, log)
        self._doing: dict[str, Callable[..., Any]] = {
            "edit": desk.edit,
            "remove": desk.remove,
            "insert": desk.insert,
            "undo": desk.undo,
            "redo": desk.redo,
            "revert": desk.revert,
            "apply": self._apply,
            "save": desk.save,
            "save_as": lambda file: desk.save_as(file),  # the names of the messages
            "open": lambda name: self._other(desk.open, name),
            "new": lambda kind, **arguments: self._other(desk.new, kind, **arguments),
            "yaml": desk.texts,
        }
        try:
            self._server = Server(_page, self._board, self.receive, host, port)
        except BaseException:
            self._exchange.close()
            self._show.close()
            raise

    @property
    def address(self) -> str:
        """What to open in a browser."""
        return self._server.address

    def begin(self) -> None:
        """Show the form, and simulate what it says, if that can be."""
        from cdpr.gui.page import hello

        sweep()
        self._board.put({"kind": "hello", **hello()})
        with self._lock:
            go_on = self._begin()
            self._put_form()
            go_on()

    def receive(self, words: Words, reader: Reader) -> None:
        """Do what a window says; what goes wrong is told there."""
        do = words.pop("do")

        def tell(level: Level, text: str) -> None:
            reader.tell(said(level, text))

        if do in self._exchange.does:
            self._exchange.begin(do, words, reader)
            return
        if do not in self._doing:
            self._show.command(do, words, tell)
            return
        try:
            self._edit(do, words, reader)
        except CdprError as error:
            tell("error", str(error))
        except Exception as error:
            self._log(traceback.format_exc())
            tell("error", f"internal error: {one_line(error)}; the terminal has more")

    def _edit(self, do: str, words: Words, reader: Reader) -> None:
        """Do what concerns the files; the form is shown anew to all windows."""
        with self._lock:
            try:
                done = call(do, self._doing[do], words)
            finally:
                self._put_form()
            if callable(done):  # what is shown then belongs to this form
                done()
        if do == "yaml":
            reader.tell({"kind": "yaml", "files": done})
        elif do in ("save", "save_as"):
            reader.tell(said("info", f"saved: {', '.join(map(str, done))}"))

    def _apply(self) -> Callable[[], None]:
        """Return what makes that run which the form says."""
        try:
            scenario = self._desk.apply()
        except CdprError as error:
            raise _in_short("not applied", error) from error
        return partial(self._show.load, scenario)

    def _scenario(self) -> Scenario:
        """Return what the form says, to be exported."""
        with self._lock:
            try:
                return self._desk.scenario()
            except CdprError as error:
                raise _in_short("not exported", error) from error

    def _open(self, name: str, reader: Reader) -> None:
        """Go on with what was imported."""
        self._edit("open", {"name": name}, reader)

    def _other(self, change: Callable[..., Any], /, *names: Any, **arguments: Any) -> Callable[[], None]:
        """Go on with other files, and show them at once."""
        change(*names, **arguments)
        return self._begin()

    def _begin(self) -> Callable[[], None]:
        """Return what makes that run which the form says; where that cannot be, nothing does, and the form says why."""
        try:
            return self._apply()
        except CdprError:
            return self._show.nothing

    def _put_form(self) -> None:
        self._board.put(self._desk.form())

    def close(self) -> None:
        """Close everything."""
        self._server.close()
        self._exchange.close()
        self._show.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _in_short(what: str, error: CdprError) -> CdprError:
    """The first of the problems of a form, and how many there are."""
    first, count = str(error).partition("\n")[0], len(error.rows)
    return CdprError(f"{what}: {f'{count} problems, the first: ' if count > 1 else ''}{first}")


def _page() -> str:
    """The page; what it takes to make it is imported when the first browser asks."""
    from cdpr.gui.page import document

    return document()
