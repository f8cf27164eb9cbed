"""Server of a running simulation for Foxglove, Lichtblick and PlotJuggler."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from threading import Lock, Thread
from time import time_ns
from typing import Any

from cdpr.base.errors import CdprError, MissingPackageError
from cdpr.log.topics import Topic
from cdpr.ui.live import foxglove_protocol as protocol
from cdpr.ui.live.sender import SERVICES, Sender

try:
    from cdpr.link.access import LOCAL, Access
    from cdpr.link.web_server import WebServer, listen
    from cdpr.link.web_socket import WebSocket
    from cdpr.ui.live.foxglove_client import Client
except ImportError as error:
    raise MissingPackageError(f"a live link needs websockets ({error}): pip install 'cdpr[live]'") from None

CLOSES = 1.0  # s that clients have to receive pending data at the end of the run
MOST_CLIENTS = 16
MOST_BYTES = 2**20  # bytes of a client's message
TOKEN = "CDPR_LIVE_TOKEN"  # environment variable with a fixed token
LEAST_TOKEN = 16  # characters
EXPOSED = "warning: anyone with this address and its token can steer the run; it is not encrypted"


class Foxglove(Sender):
    """Server of the Foxglove WebSocket protocol.

    It sends samples, and receives published messages, service calls and parameters.

    Args:
        host, port: listening address; port 0 selects a free one.
        say: called with refusals.
        parameters: names and values of settable parameters besides `paused` and `speed`.
        programs: True if programs need no token; web pages always do.

    Attributes:
        port: listening port.
        url: address for clients, with the token.

    Raises:
        CdprError: if it cannot listen there, such as if the port is in use.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 8765,
        say: Callable[[str], None] = lambda text: None,
        parameters: dict[str, Any] | None = None,
        programs: bool = False,
    ) -> None:
        super().__init__(host, port, say, parameters)
        access = _access(self.host, programs)
        try:
            listening = listen(self.host, port)
        except (OSError, OverflowError) as error:
            text = getattr(error, "strerror", None) or error
            raise CdprError(
                f"--live-port: cannot listen at {self.address}: {text}; use --live-port 0 for any free port, or "
                "another --live-host"
            ) from None
        self._topics: tuple[Topic, ...] = ()
        self._session = str(time_ns() // 10**6)
        self._clients: list[Client] = []
        self._lock = Lock()
        self._server = WebServer(
            listening, access, self._serve, most=MOST_CLIENTS, max_size=MOST_BYTES, subprotocols=protocol.SUBPROTOCOLS
        )
        self.port = self._server.port
        self.url = access.address("ws", self.port)
        self.where = f"{self.url} for Foxglove, Lichtblick and PlotJuggler"
        if programs:
            self.where += "; programs need no token"
        if self.host not in LOCAL:
            say(EXPOSED)

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Also send the values to clients that subscribe to parameters."""
        super().changed(parameters)
        for client in self._every():
            client.changed(parameters)

    def _report(self, text: str) -> None:
        """Also send the text to all clients."""
        super()._report(text)
        for client in self._every():
            client.reply(protocol.status(protocol.WARNING, text))

    def _serve(self, web_socket: WebSocket) -> None:
        """Serve a client until it disconnects."""
        from cdpr.base.version import VERSION

        client = Client(self, web_socket)
        with self._lock:  # topics are offered once, here or in _open
            self._clients.append(client)
            client.reply(protocol.server_info(self._session, VERSION))
            client.offer(self._topics)
        client.reply(protocol.advertise_services(SERVICES))
        try:
            client.serve()
        finally:
            with self._lock:
                self._clients.remove(client)

    def _every(self) -> list[Client]:
        with self._lock:
            return list(self._clients)

    def _open(self, topics: tuple[Topic, ...]) -> None:
        with self._lock:
            self._topics = topics
            for client in self._clients:
                client.offer(topics)

    def _wanted(self) -> list[bool]:
        wanted = {channel for client in self._every() for channel in client.subscriptions}
        return [channel in wanted for channel in range(len(self._topics))]

    def _put(self, time: int, messages: Iterator[tuple[int, bytes]]) -> None:
        found = list(messages)
        for client in self._every():
            client.show(time, found)

    def _shut(self) -> None:
        leaving = [Thread(target=client.leave, args=(CLOSES,), daemon=True) for client in self._every()]
        for thread in leaving:
            thread.start()
        for thread in leaving:
            thread.join()
        self._server.close()


def _access(host: str, programs: bool) -> Access:
    """Return the admission rules: any page that knows the token, such as Foxglove's own."""
    token = os.environ.get(TOKEN, "")
    if not token:
        return Access(host, pages=True, programs=programs)
    if len(token) < LEAST_TOKEN or not (token.isascii() and token.replace("-", "").replace("_", "").isalnum()):
        raise CdprError(f"{TOKEN}: expected {LEAST_TOKEN} or more letters, digits, '-' and '_'; make another one")
    return Access(host, token, pages=True, programs=programs)
