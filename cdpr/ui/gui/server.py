"""HTTP page and WebSockets of the GUI, on one port."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from http import HTTPStatus
from threading import Thread
from typing import Any

from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Response

from cdpr.base.errors import CdprError
from cdpr.link.access import Access
from cdpr.link.web_server import WebServer, listen
from cdpr.link.web_socket import WebSocket
from cdpr.ui.gui.broadcast import Broadcast, Reader
from cdpr.ui.gui.choices import in_window

PORTS = range(8080, 8100)  # the first free port is used by default
MOST_BYTES = 2**20  # of a message
MOST_UPLOAD = 16 * 2**20  # bytes of files attached to a message, the limit of an import
MOST_WINDOWS = 16
STUCK = 10  # s until a window that does not receive is disconnected; it reconnects when it can

# No external resources, no embedding in frames, no leak of the token by a referrer.
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
}

Words = dict[str, Any]
Receive = Callable[[Words, Reader], None]


class Server:
    """Server of the page and of the broadcast's messages.

    Args:
        page: returns the page.
        broadcast: messages for windows.
        receive: called with each message and its window; must neither raise nor block.
        host: address or name to listen on.
        port: port; defaults to the first free one of `PORTS`, or any free port.

    Raises:
        CdprError: if it cannot listen there.
    """

    def __init__(
        self,
        page: Callable[[], str],
        broadcast: Broadcast,
        receive: Receive,
        host: str = "127.0.0.1",
        port: int | None = None,
    ) -> None:
        self._page, self._broadcast, self._receive = page, broadcast, receive
        self._access = Access(host)
        self._server = self._listen(port)
        self.port: int = self._server.port

    @property
    def address(self) -> str:
        """Address to open in a browser."""
        return self._access.address("http", self.port)

    def close(self) -> None:
        """Disconnect all windows and stop listening."""
        self._server.close()

    def _listen(self, port: int | None) -> WebServer:
        host = self._access.host
        for each in [port] if port is not None else [*PORTS, 0]:
            try:
                listening = listen(host, each)
            except (OSError, OverflowError) as error:
                failed = error
                continue
            return WebServer(
                listening,
                self._access,
                self._serve,
                most=MOST_WINDOWS,
                max_size=MOST_BYTES + 1 + MOST_UPLOAD,
                page=self._document,
            )
        number = getattr(failed, "errno", None) or 0
        reason = os.strerror(number) if number > 0 else getattr(failed, "strerror", None) or failed
        where = host if port is None else f"{host}, port {port}"
        hint = "" if port is None else "; leave out --port for one that is free"
        raise CdprError(f"{where}: {reason}{hint}") from failed

    def _document(self, host: str) -> Response:
        """Return the page; `host` is the Host header of the request."""
        body = self._page().encode()
        headers = {"Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(body)), "Connection": "close"}
        headers |= {name: value.replace("{host}", host) for name, value in HEADERS.items()}
        return Response(HTTPStatus.OK.value, HTTPStatus.OK.phrase, Headers(headers), body)

    def _serve(self, window: WebSocket) -> None:
        """Serve a window until it disconnects."""
        reader = self._broadcast.join()
        sender = Thread(target=_send, args=(window, reader), name="window", daemon=True)
        sender.start()
        try:
            for message in window:
                words, files = _parts(message)
                if len(words) > MOST_BYTES:
                    window.close(CloseCode.MESSAGE_TOO_BIG)
                    break
                self._parse_and_receive(words, files, reader)
        finally:
            self._broadcast.leave(reader)
            sender.join(STUCK)

    def _parse_and_receive(self, text: str | bytes, files: bytes, reader: Reader) -> None:
        try:
            words = json.loads(text, parse_constant=_no_number)
        except (ValueError, RecursionError) as error:
            reader.send(notice("error", f"expected JSON: {type(error).__name__}"))
            return
        if not isinstance(words, Mapping) or not isinstance(words.get("do"), str):
            reader.send(notice("error", 'expected an object with a text "do", such as {"do": "run"}'))
            return
        self._receive({**words, **({"body": files} if files else {})}, reader)


def notice(level: str, text: str, **more: str) -> dict[str, Any]:
    """Return a message for users, with GUI fields in place of command-line options."""
    return {"kind": "message", "level": level, "text": in_window(text), **more}


def _parts(message: str | bytes) -> tuple[str | bytes, bytes]:
    """Return the text of a message and its attached files, which follow a line feed in binary messages."""
    if isinstance(message, str):
        return message, b""
    end = message.find(b"\n", 0, MOST_BYTES + 1)
    return (message, b"") if end < 0 else (message[:end], message[end + 1 :])


def _send(window: WebSocket, reader: Reader) -> None:
    try:
        for text in reader:
            window.send(text)
    except ConnectionError:
        pass  # disconnected or stuck


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is not a number")
