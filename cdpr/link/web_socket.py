"""Server side of one open WebSocket: messages in and out, pings, time limits."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import suppress
from threading import Lock
from time import monotonic

from websockets.exceptions import InvalidState
from websockets.frames import CloseCode, Frame, Opcode
from websockets.http11 import Response
from websockets.protocol import OPEN
from websockets.server import ServerProtocol

QUIET = 10.0  # s without data from the client, after which it is pinged; also the longest time of a write
SILENT = 3  # such periods after which the client counts as gone
CLOSES = 1.0  # s that the other side has to answer a closing handshake
CHUNK = 65536  # bytes that are read at once

Message = str | bytes


class WebSocket:
    """An open WebSocket. One thread iterates over its messages; any thread may send, close and abort.

    Args:
        connection: the connected socket; this object closes it.
        protocol: the state after the opening handshake.
        rest: bytes that came behind the request.
    """

    def __init__(self, connection: socket.socket, protocol: ServerProtocol, rest: bytes) -> None:
        self._socket, self._protocol, self._rest = connection, protocol, rest
        self._lock = Lock()
        connection.settimeout(QUIET)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def accept(self, response: Response) -> None:
        """Finish the opening handshake. Raises OSError."""
        with self._lock:
            self._protocol.send_response(response)
            self._write()

    def finish(self) -> None:
        """Close, and wait for the other side to do so, too."""
        self.close()
        until = monotonic() + CLOSES
        with suppress(OSError):
            while (time := until - monotonic()) > 0:
                self._socket.settimeout(time)
                if not self._socket.recv(CHUNK):
                    return

    @property
    def subprotocol(self) -> str | None:
        """The subprotocol that was agreed on."""
        return self._protocol.subprotocol

    def __iter__(self) -> Iterator[Message]:
        """Yield messages until the connection ends, whatever ends it."""
        text, message = False, bytearray()  # not a list of fragments: empty ones would fill any memory
        with suppress(OSError):
            for frame in self._frames():
                if frame.opcode is not Opcode.CONT:
                    text = frame.opcode is Opcode.TEXT
                message += frame.data
                if not frame.fin:
                    continue
                data = bytes(message)
                message.clear()
                try:
                    yield data.decode() if text else data
                except UnicodeDecodeError:
                    with self._lock:
                        self._protocol.fail(CloseCode.INVALID_DATA)
                        self._write()
                    return

    def _frames(self) -> Iterator[Frame]:
        """Yield data frames; answer pings and closing handshakes."""
        data, self._rest = self._rest, b""
        while True:
            if data:
                with self._lock:
                    self._protocol.receive_data(data)
                    events = self._protocol.events_received()
                    self._write()
                for event in events:
                    if isinstance(event, Frame) and event.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
                        yield event
                if self._protocol.close_expected():
                    self._socket.settimeout(CLOSES)
            data = self._receive()
            if not data:
                return

    def _receive(self) -> bytes:
        """Return what comes next; nothing where the connection has ended or the client is silent for too long."""
        for _ in range(SILENT):
            try:
                return self._socket.recv(CHUNK)
            except TimeoutError:
                with self._lock:
                    if self._protocol.state is not OPEN:
                        return b""
                    self._protocol.send_ping(b"")
                    self._write()
        return b""

    def send(self, *messages: Message) -> None:
        """Send messages in one write. Raises ConnectionError where the connection has ended or takes nothing more."""
        with self._lock:
            try:
                for message in messages:
                    if isinstance(message, str):
                        self._protocol.send_text(message.encode())
                    else:
                        self._protocol.send_binary(message)
                self._write()
            except (InvalidState, OSError) as error:
                self.abort()
                raise ConnectionError("the WebSocket is closed") from error

    def close(self, code: CloseCode = CloseCode.NORMAL_CLOSURE) -> None:
        """Begin the closing handshake; a connection that takes nothing is cut."""
        if not self._lock.acquire(timeout=CLOSES):
            self.abort()
            return
        try:
            if self._protocol.state is OPEN:
                self._protocol.send_close(code)
                self._socket.settimeout(CLOSES)
                self._write()
        except OSError:
            self.abort()
        finally:
            self._lock.release()

    def abort(self) -> None:
        """Cut the connection: whatever waits for it goes on."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def _write(self) -> None:
        """Send what the protocol has to say; b"" of it is the end."""
        out = self._protocol.data_to_send()
        if data := b"".join(out):
            self._socket.sendall(data)
        if out and not out[-1]:
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_WR)
