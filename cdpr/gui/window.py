"""The window: joins what is edited, what runs, and who looks on."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from cdpr.gui.board import Board, Reader
from cdpr.gui.server import Server, Words, said
from cdpr.gui.show import Level, Show
from cdpr.scenario import Scenario

STEERING = [
    "run",
    "pause",
    "step",
    "reset",
    "speed",
    "push",
    "release",
    "cut",
    "jam",
    "limits",
    "stop",
    "target",
    "set",
    "save_run",
    "save_session",
]


class Window:
    """A scenario that is edited, simulated and shown.

    Args:
        file: scenario or robot file, or the name of an example.
        host: where to listen.
        port: likewise; any that is free unless given.
    """

    def __init__(self, scenario: Scenario, host: str = "127.0.0.1", port: int | None = None) -> None:
        self.board = Board()
        self.show = Show(self.board)
        try:
            self.show.load(scenario)
            self.server = Server(page, self.board, self.receive, host, port)
        except BaseException:
            self.show.close()
            raise
        from cdpr.gui.drawing import hello

        self.board.put({"kind": "form"})
        self.board.put(hello())

    def receive(self, words: Words, reader: Reader) -> None:
        """Do what a window says; what goes wrong is told there."""
        do = words.pop("do")

        def tell(level: Level, text: str) -> None:
            reader.tell(said(level, text))

        if do in STEERING:
            self.show.command(do, words, tell)
        else:
            tell("error", f"'{do[:40]}' is not known")

    def close(self) -> None:
        """Close everything."""
        self.server.close()
        self.show.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def page() -> str:
    """Return the page."""
    return "<!DOCTYPE html><title>cdpr</title>"
