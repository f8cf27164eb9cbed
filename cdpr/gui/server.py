"""The page by HTTP and the sockets of its windows, on one port, for nobody but who has the address that was printed.

Whoever reaches the port may run what the user may run, so three things are asked of every request: the token of the
printed address, a Host that is an address and no stranger's name (a name may be made to point here: DNS rebinding), and
of sockets an Origin that is this very page, which browsers tell truly.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import logging
import os
import secrets
import socket
import struct
from collections.abc import Callable, Mapping
from http import HTTPStatus
from ipaddress import ip_address
from threading import Lock, Thread
from typing import Any
from urllib.parse import parse_qs, urlsplit

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.sync.server import Server as Listener
from websockets.sync.server import ServerConnection, serve

from cdpr.errors import CdprError
from cdpr.gui.board import Board, Reader
from cdpr.gui.choices import in_window

PORTS = range(8080, 8100)  # the first that is free, unless one is asked for
MOST_BYTES = 2**20  # of what a window says
MOST_UPLOAD = 16 * 2**20  # bytes of files that come with it, as much as an import reads of one
MOST_WINDOWS = 16
STUCK = 10  # s after which a window that takes nothing is given up; it joins again when it can
LOCAL = ("localhost", "127.0.0.1", "::1")

# Nothing is fetched from anywhere; nobody frames the page; the token goes nowhere.
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

_quiet = logging.getLogger("cdpr.gui.server")
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False  # what strangers send wrong is not the user's to read


class Server:
    """Serves a page, and to its windows what is on the board.

    Args:
        page: the page as it is sent.
        board: what windows show.
        receive: takes what a window says, and the window; must not raise, nor wait.
        host: address or name to listen on.
        port: which port; the first free one of `PORTS`, or else any, unless given.

    Raises CdprError where it cannot listen there.
    """

    def __init__(
        self, page: Callable[[], str], board: Board, receive: Receive, host: str = "127.0.0.1", port: int | None = None
    ) -> None:
        self._page, self._board, self._receive, self._host = page, board, receive, host
        self.token = secrets.token_urlsafe(24)
        self._windows: set[ServerConnection] = set()
        self._lock = Lock()
        self._listener = self._listen(port)
        self.port: int = self._listener.socket.getsockname()[1]
        self._thread = Thread(target=self._listener.serve_forever, name="server", daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """What to open in a browser."""
        anywhere = self._host in ("", "0.0.0.0", "::")
        host = socket.gethostname() if anywhere else self._host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/?token={self.token}"

    def close(self) -> None:
        """Let all windows go, and stop listening."""
        waiting = Thread(target=self._listener.shutdown, daemon=True)
        waiting.start()
        waiting.join(1.0)
        with self._lock:
            stuck = list(self._windows)
        for window in stuck:  # one that takes nothing does not say goodbye, either
            _abort(window.socket)
        waiting.join(STUCK)

    def _listen(self, port: int | None) -> Listener:
        tried = [port] if port is not None else [*PORTS, 0]
        for each in tried:
            try:
                return self._serve(each)
            except (OSError, OverflowError) as error:
                failed = error
        number = getattr(failed, "errno", None) or 0
        reason = os.strerror(number) if number > 0 else getattr(failed, "strerror", None) or failed
        where = self._host if port is None else f"{self._host}, port {port}"
        hint = "" if port is None else "; leave out --port for one that is free"
        raise CdprError(f"{where}: {reason}{hint}") from failed

    def _serve(self, port: int) -> Listener:
        family = socket.AF_INET6 if ":" in self._host else socket.AF_INET
        both = self._host == "::" and socket.has_dualstack_ipv6()  # the machine's name may mean either address
        listening = socket.create_server((self._host, port), family=family, dualstack_ipv6=both)
        return serve(
            self._hold,
            sock=listening,
            process_request=self._answer,
            compression=None,  # it would cost more than all the rest, to spare bytes that never leave the machine
            max_size=MOST_BYTES + 1 + MOST_UPLOAD,
            logger=_quiet,
            server_header=None,
        )

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the page, a refusal, or None for a socket that may be opened."""
        hosts = request.headers.get_all("Host")
        host = hosts[0] if len(hosts) == 1 else ""  # of two, who knows which one was meant
        url = urlsplit(request.path)
        token = parse_qs(url.query).get("token", [""])[0]
        if not self._is_here(host):
            return _refusal(HTTPStatus.MISDIRECTED_REQUEST, "this is not the host that was asked for")
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return _refusal(HTTPStatus.FORBIDDEN, "open the address that cdpr gui has printed, with its token")
        if url.path != "/":
            return _refusal(HTTPStatus.NOT_FOUND, "there is nothing here")
        if "Upgrade" in request.headers:
            return self._admit(request.headers, host)
        return _response(HTTPStatus.OK, self._page(), "text/html; charset=utf-8", host)

    def _admit(self, headers: Headers, host: str) -> Response | None:
        origins = headers.get_all("Origin")
        if any(origin != f"http://{host}" for origin in origins):
            return _refusal(HTTPStatus.FORBIDDEN, "another page's script is not let in")
        with self._lock:
            full = len(self._windows) >= MOST_WINDOWS
        return _refusal(HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_WINDOWS} windows are open: close one") if full else None

    def _is_here(self, host: str) -> bool:
        """Whether a Host names this machine: by an address, or by a name that was chosen for it."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in LOCAL or name == self._host.lower():
            return True
        if self._host in LOCAL:
            return False
        try:
            ip_address(name)
        except ValueError:
            return name == socket.gethostname().lower()
        return True

    def _hold(self, window: ServerConnection) -> None:
        """Serve one window until it goes."""
        window.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", STUCK, 0))
        reader = self._board.join()
        sender = Thread(target=_send, args=(window, reader), name="window", daemon=True)
        with self._lock:
            self._windows.add(window)
        sender.start()
        try:
            for message in window:
                words, files = _parts(message)
                if len(words) > MOST_BYTES:
                    window.close(CloseCode.MESSAGE_TOO_BIG)
                    break
                self._take(words, files, reader)
        except ConnectionClosed:
            pass
        finally:
            self._board.leave(reader)
            with self._lock:
                self._windows.discard(window)
            sender.join(STUCK)

    def _take(self, text: str | bytes, files: bytes, reader: Reader) -> None:
        try:
            words = json.loads(text, parse_constant=_no_number)
        except (ValueError, RecursionError) as error:
            reader.tell(said("error", f"a message that is no JSON: {type(error).__name__}"))
            return
        if not isinstance(words, Mapping) or not isinstance(words.get("do"), str):
            reader.tell(said("error", 'a message is an object with a text "do", such as {"do": "run"}'))
            return
        self._receive({**words, **({"body": files} if files else {})}, reader)


def said(level: str, text: str, **more: str) -> dict[str, Any]:
    """Return a message for people, in the words of the window."""
    return {"kind": "message", "level": level, "text": in_window(text), **more}


def _parts(message: str | bytes) -> tuple[str | bytes, bytes]:
    """What a window says, and the files that come with it: behind a line feed, where the message is bytes."""
    if isinstance(message, str):
        return message, b""
    end = message.find(b"\n", 0, MOST_BYTES + 1)
    return (message, b"") if end < 0 else (message[:end], message[end + 1 :])


def _send(window: ServerConnection, reader: Reader) -> None:
    try:
        for text in reader:
            window.send(text)
    except (ConnectionClosed, OSError):
        _abort(window.socket)


def _abort(connection: socket.socket) -> None:
    with contextlib.suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is no number")


def _refusal(status: HTTPStatus, text: str) -> Response:
    return _response(status, f"{text}\n", "text/plain; charset=utf-8", "")


def _response(status: HTTPStatus, text: str, kind: str, host: str) -> Response:
    body = text.encode()
    headers = {"Content-Type": kind, "Content-Length": str(len(body)), "Connection": "close"}
    headers |= {name: value.replace("{host}", host) for name, value in HEADERS.items()}
    return Response(status.value, status.phrase, Headers(headers), body)
