"""One message to a WebSocket server of this process, sent as a client sends it (RFC 6455)."""

from __future__ import annotations

import os
import socket
from base64 import b64encode
from struct import pack

WAITS = 1.0  # s, for the server
MOST = 125  # bytes of a frame whose length stands in one byte
_TEXT, _CLOSE = 0x81, 0x88  # whole in one frame
_MASKED = 0x80


def say(host: str, port: int, protocol: str, text: str) -> None:
    """Connect, say `text`, at most MOST bytes, and wait until the server has heard it and closes the connection.

    Raises OSError where nobody is there, or takes too long.
    """
    with socket.create_connection((host, port), WAITS) as link:
        key = b64encode(os.urandom(16)).decode()
        lines = ("GET / HTTP/1.1", "Host: localhost", "Upgrade: websocket", "Connection: Upgrade")
        more = (f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", f"Sec-WebSocket-Protocol: {protocol}")
        link.sendall("\r\n".join((*lines, *more, "", "")).encode())
        heard = b""
        while b"\r\n\r\n" not in heard:
            heard += (part := link.recv(4096))
            if not part:
                raise ConnectionError("the server closed the connection")
        link.sendall(_frame(_TEXT, text.encode()) + _frame(_CLOSE, b""))
        while link.recv(65536):
            pass


def _frame(kind: int, data: bytes) -> bytes:
    """A frame of a client, masked by zeros."""
    assert len(data) <= MOST
    return pack("BB4x", kind, _MASKED | len(data)) + data
