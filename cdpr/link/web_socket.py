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

QUIET = 10.0  # s without data from the client before a ping; also the time limit of a write
SILENT = 3  # number of such periods after which the client counts as gone
CLOSES = 1.0  # s, time limit of the closing handshake
CHUNK = 65536  # bytes per read

Message = str | bytes


class WebSocket:
    """Open WebSocket. One thread iterates over its messages; any thread may send, close and abort.

    Args:
        connection: the connected socket; closed by the server.
        protocol: protocol state after the opening handshake.
        rest: bytes received after the request.
    """

    def __init__(self, connection: socket.socket, protocol: ServerProtocol, rest: bytes) -> None:
        self._socket, self._protocol, self._rest = connection, protocol, rest
        self._lock = Lock()
        connection.settimeout(QUIET)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def accept(self, response: Response) -> None:
        """Finish the opening handshake.

        Raises:
            OSError: if the connection fails.
        """
        with self._lock:
            self._protocol.send_response(response)
            self._write()

    def finish(self) -> None:
        """Close the connection and wait for the client to close it."""
        self.close()
        until = monotonic() + CLOSES
        with suppress(OSError):
            while (time := until - monotonic()) > 0:
                self._socket.settimeout(time)
                if not self._socket.recv(CHUNK):
                    return

    @property
    def subprotocol(self) -> str | None:
        """Negotiated subprotocol."""
        return self._protocol.subprotocol

    def __iter__(self) -> Iterator[Message]:
        """Yield messages until the connection ends for any reason."""
        text, message = False, bytearray()  # not a list: empty fragments would fill the memory
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
        """Return the next bytes; b"" if the connection has ended or the client is silent for too long."""
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
        """Send messages in one write.

        Raises:
            ConnectionError: if the connection has ended or the client does not read.
        """
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
        """Start the closing handshake; cut a blocked connection."""
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
        """Cut the connection; threads that wait for it continue."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def _write(self) -> None:
        """Send the pending data of the protocol; an empty item marks the end."""
        out = self._protocol.data_to_send()
        if data := b"".join(out):
            self._socket.sendall(data)
        if out and not out[-1]:
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_WR)
