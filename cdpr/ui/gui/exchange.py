"""Import and export in a window, parallel to editing and simulation, one at a time."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from threading import Lock, Thread

from cdpr.base.errors import CdprError, one_line
from cdpr.scenario.scenario import Scenario
from cdpr.simulation.arguments import call
from cdpr.ui.gui.broadcast import Reader
from cdpr.ui.gui.incoming import Incoming
from cdpr.ui.gui.server import Words, notice


class Exchange:
    """Import and export requests of windows; each answer names its request in `about`.

    Args:
        scenario: returns the scenario of the form; raises CdprError if it is invalid.
        open: opens a file for a window.
        log: receives text that only the terminal shows.
    """

    def __init__(
        self, scenario: Callable[[], Scenario], open: Callable[[str, Reader], None], log: Callable[[str], None]
    ) -> None:
        self._scenario, self._open, self._log = scenario, open, log
        self._incoming = Incoming()
        self._going = Lock()
        self._thread: Thread | None = None
        self._doing: dict[str, Callable[..., Iterable[Words]]] = {
            "import": self._incoming.read,
            "take": self._take,
            "export": self._export,
        }
        self.does = (*self._doing, "give_up")

    def begin(self, do: str, words: Words, reader: Reader) -> None:
        """Start a request in `does`; only this window is notified of the result."""
        if do == "give_up":
            self._incoming.give_up(reader)
            return
        if not self._going.acquire(blocking=False):
            reader.send(notice("error", f"{do}: another import or export is in progress: wait for it", about=do))
            return
        # Threads inherit the daemon flag, even those that start processes, and this window's thread is a daemon.
        self._thread = Thread(target=self._guarded, args=(do, words, reader), name="exchange", daemon=False)
        self._thread.start()

    def close(self) -> None:
        """Abort a running import, and wait for a running export."""
        self._incoming.close()
        if self._thread is not None:
            self._thread.join()

    def _guarded(self, do: str, words: Words, reader: Reader) -> None:
        messages: list[Words] = []
        try:
            messages.extend(call(do, partial(self._doing[do], reader), words))
        except CdprError as error:
            messages.append(notice("error", str(error)))
        except Exception as error:
            self._log(traceback.format_exc())
            messages.append(notice("error", f"internal error: {one_line(error)}; the terminal has more"))
        finally:
            self._going.release()  # before the answer: its receiver may send the next request
        for message in messages:
            reader.send({**message, "about": do})

    def _take(self, reader: Reader, out: str = "", open: str = "") -> Iterator[Words]:
        """Write the imported files, and open one of them."""
        written, file = self._incoming.write(reader, out, open)
        yield notice("info", f"imported: {', '.join(written)}")
        self._open(file, reader)

    def _export(
        self, reader: Reader, to: str = "", style: str = "", version: str = "", pulleys: str = ""
    ) -> Iterator[Words]:
        """Send the scenario as a file for another program."""
        from cdpr.ui.gui.outgoing import exported

        given = {key: value for key, value in (("style", style), ("version", version), ("pulleys", pulleys)) if value}
        file, left_out = exported(self._scenario(), to, given)
        yield file
        for each in left_out:
            yield notice("warning", f"{file['name']}: left out: {each}")
        yield notice("info", f"exported: {file['name']}")
