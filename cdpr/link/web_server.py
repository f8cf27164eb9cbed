"""HTTP and WebSocket server of cdpr: bounded connections, time limits, access control.

Each connection has a thread. Connections that are not yet admitted are few and short-lived: if too many wait, the
oldest is closed, so that idle connections cannot block new ones.
"""

from __future__ import annotations

import errno
import logging
import re
import socket
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from http import HTTPStatus
from threading import Lock, Thread, current_thread
from time import monotonic, sleep
from typing import cast

from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.server import ServerProtocol
from websockets.typing import Subprotocol

from cdpr.link.access import Access, RefusedError
from cdpr.link.web_socket import CLOSES, WebSocket

OPENS = 5.0  # s, time limit for a client to send its request and to receive the answer
MOST_HEAD = 16384  # bytes of a request without body
MOST_WAITING = 64  # connections that are not yet admitted
LINGER = 0.5, 65536  # s and bytes of a refused request that are still read, so that the client receives the answer
SHUT = (errno.EBADF, errno.EINVAL, errno.ENOTSOCK)  # errors of a socket that no longer listens
_END = re.compile(rb"\r?\n\r?\n")
PAUSE = 0.05  # s to wait after a failed accept

_quiet = logging.getLogger("cdpr.link.web_server")
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False  # malformed input of other programs does not concern the user


class WebServer:
    """Server of one optional page and of WebSockets, all at the path "/".

    Args:
        listening: the socket, see `listen`; closed with this object.
        access: admission rules.
        serve: called in its own thread with each open WebSocket, which is closed when it returns.
        most: maximum number of open WebSockets.
        max_size: maximum size of a client's message, bytes.
        page: function of the Host header that answers requests without WebSocket; optional.
        subprotocols: names of which a client must offer one, preferred first.
    """

    def __init__(
        self,
        listening: socket.socket,
        access: Access,
        serve: Callable[[WebSocket], None],
        *,
        most: int,
        max_size: int,
        page: Callable[[str], Response] | None = None,
        subprotocols: Sequence[str] = (),
    ) -> None:
        self._listening, self._access, self._serve = listening, access, serve
        self._most, self._max_size, self._page = most, max_size, page
        self._subprotocols = [Subprotocol(name) for name in subprotocols] or None
        self._lock = Lock()
        self._waiting = dict[socket.socket, None]()  # ordered
        self._open = set[WebSocket]()
        self._threads = set[Thread]()
        self._closed = False
        self.port: int = listening.getsockname()[1]
        self._accepting = Thread(target=self._accept, name="web server", daemon=True)
        self._accepting.start()

    def close(self) -> None:
        """Close all connections and stop listening."""
        with self._lock:
            self._closed = True
        with suppress(OSError):
            self._listening.shutdown(socket.SHUT_RDWR)  # wakes the accepting thread
        self._accepting.join()
        self._listening.close()
        with self._lock:
            waiting, opened, threads = list(self._waiting), list(self._open), list(self._threads)
        for connection in waiting:
            _cut(connection)
        partings = [Thread(target=each.close, args=(CloseCode.GOING_AWAY,), daemon=True) for each in opened]
        for thread in partings:
            thread.start()
        until = monotonic() + CLOSES
        for thread in threads:
            thread.join(max(0.0, until - monotonic()))
        for each in opened:
            each.abort()
        for thread in threads:
            thread.join(CLOSES)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listening.accept()
            except OSError as error:
                if self._closed or error.errno in SHUT:
                    return
                self._drop_oldest()  # resource shortage or network error of one connection: continue
                sleep(PAUSE)
                continue
            self._begin(connection)

    def _begin(self, connection: socket.socket) -> None:
        """Handle a connection in its own thread."""
        thread = Thread(target=self._handle, args=(connection,), name="web client", daemon=True)
        with self._lock:
            crowded = len(self._waiting) >= MOST_WAITING
            self._waiting[connection] = None
            self._threads.add(thread)
        if crowded:
            self._drop_oldest()
        try:
            thread.start()
        except RuntimeError:  # the system has no more threads
            self._forget(connection, thread)
            connection.close()

    def _drop_oldest(self) -> None:
        with self._lock:
            oldest = next(iter(self._waiting), None)
            if oldest is not None:
                del self._waiting[oldest]
                _cut(oldest)

    def _forget(self, connection: socket.socket, thread: Thread) -> None:
        with self._lock:
            self._waiting.pop(connection, None)
            self._threads.discard(thread)

    def _handle(self, connection: socket.socket) -> None:
        try:
            with closing(connection), suppress(OSError):
                self._answer(connection)
        finally:
            self._forget(connection, current_thread())

    def _answer(self, connection: socket.socket) -> None:
        """Read a request, answer it, and serve its WebSocket."""
        until = monotonic() + OPENS
        protocol = ServerProtocol(subprotocols=self._subprotocols, max_size=self._max_size, logger=_quiet)
        rest = b""
        try:
            head, rest = _head(connection, until)
            response = self._response(_request(protocol, head), protocol)
        except RefusedError as refused:
            response = plain_response(refused.status, f"{refused}\n")
        if response.status_code == HTTPStatus.SWITCHING_PROTOCOLS:
            self._hold(connection, protocol, response, rest)
            return
        connection.settimeout(OPENS)
        connection.sendall(response.serialize())
        _linger(connection)

    def _response(self, request: Request, protocol: ServerProtocol) -> Response:
        """Return the page, or the answer that opens a WebSocket.

        Raises:
            RefusedError: if the request is not admitted or malformed.
        """
        headers = request.headers
        hosts = headers.get_all("Host")
        path = self._access.check(request.path, hosts, headers.get_all("Origin"))
        if getattr(request, "method", "GET") != "GET":
            raise RefusedError(HTTPStatus.METHOD_NOT_ALLOWED, "only GET is supported")
        if path not in ("", "/"):
            raise RefusedError(HTTPStatus.NOT_FOUND, "not found")
        if "Upgrade" not in headers:
            if self._page is None:
                raise RefusedError(HTTPStatus.UPGRADE_REQUIRED, "open a WebSocket here")
            return self._page(hosts[0])
        with suppress(ValueError):  # non-text headers
            response = protocol.accept(request)
            if response.status_code < HTTPStatus.INTERNAL_SERVER_ERROR:
                return response
        raise RefusedError(HTTPStatus.BAD_REQUEST, "the WebSocket request is malformed")

    def _hold(self, connection: socket.socket, protocol: ServerProtocol, response: Response, rest: bytes) -> None:
        """Open a WebSocket and serve it until it ends."""
        with self._lock:
            full = self._closed or len(self._open) >= self._most
            if not full:
                self._waiting.pop(connection, None)
                opened = WebSocket(connection, protocol, rest)
                self._open.add(opened)
        if full:
            text = f"{self._most} connections are open: close one\n"
            connection.sendall(plain_response(HTTPStatus.SERVICE_UNAVAILABLE, text).serialize())
            _linger(connection)
            return
        try:
            opened.accept(response)
            self._serve(opened)
        finally:
            opened.finish()
            with self._lock:
                self._open.discard(opened)


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket; "::" also accepts IPv4 if the system supports both.

    Raises:
        OSError, OverflowError: if it cannot listen there.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    both = host == "::" and socket.has_dualstack_ipv6()
    return socket.create_server((host, port), family=family, dualstack_ipv6=both)


def plain_response(status: HTTPStatus, text: str) -> Response:
    """Return a response of plain text."""
    body = text.encode()
    kinds = {"Content-Type": "text/plain; charset=utf-8", "X-Content-Type-Options": "nosniff"}
    rest = {"Content-Length": str(len(body)), "Connection": "close", "Cache-Control": "no-store"}
    return Response(status.value, status.phrase, Headers(kinds | rest), body)


def _head(connection: socket.socket, until: float) -> tuple[bytes, bytes]:
    """Return a request up to its empty line, and the bytes after it.

    Raises:
        RefusedError: if the request is incomplete, late or too long.
        OSError: if the connection fails.
    """
    data = bytearray()
    while not (end := _END.search(data)):
        connection.settimeout(max(until - monotonic(), 1e-3))
        try:
            found = connection.recv(MOST_HEAD)
        except TimeoutError:
            raise RefusedError(HTTPStatus.REQUEST_TIMEOUT, f"the request is incomplete after {OPENS:g} s") from None
        if not found:
            raise RefusedError(HTTPStatus.BAD_REQUEST, "the request is incomplete")
        data += found
        if len(data) > MOST_HEAD:
            text = f"the request is longer than {MOST_HEAD} bytes"
            raise RefusedError(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, text)
    return bytes(data[: end.end()]), bytes(data[end.end() :])


def _request(protocol: ServerProtocol, head: bytes) -> Request:
    """Return the parsed request.

    Raises:
        RefusedError: if it is malformed.
    """
    protocol.receive_data(head)
    events = protocol.events_received()
    if not events:
        raise RefusedError(HTTPStatus.BAD_REQUEST, "the request is malformed")
    return cast(Request, events[0])


def _linger(connection: socket.socket) -> None:
    """Read the rest of a request so that the client receives the answer: closing with unread data would discard it."""
    until, left = monotonic() + LINGER[0], LINGER[1]
    connection.shutdown(socket.SHUT_WR)
    while left > 0 and (time := until - monotonic()) > 0:
        connection.settimeout(time)
        data = connection.recv(left)
        if not data:
            return
        left -= len(data)


def _cut(connection: socket.socket) -> None:
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)
