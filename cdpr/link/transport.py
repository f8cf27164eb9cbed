"""Bytes to and from a peer: over the pipes of a program that is started here, or a socket on which it listens."""

from __future__ import annotations

import contextlib
import hashlib
import os
import select
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

from cdpr.errors import BackendDied, CdprError

MOST_BYTES = 16 * 2**20  # of a program
RETRY = 0.02  # s, between two tries to reach a peer that does not listen yet
GRACE = 1.0  # s, that a program has to end by itself when its input ends
SHOWN = 2000  # of what a program said last on stderr, characters


class Transport:
    """A pair of descriptors that never block.

    Attributes:
        called: what the peer is called in messages.
    """

    def __init__(self, called: str, receiving: int, sending: int, closing: contextlib.ExitStack) -> None:
        self.called = called
        self._receiving, self._sending, self._closing = receiving, sending, closing
        for descriptor in {receiving, sending}:
            os.set_blocking(descriptor, False)

    def send(self, data: bytes, until: float) -> None:
        """Send all of it before a time of `time.monotonic`. Raises BackendDied."""
        view = memoryview(data)
        while view:
            sent = self.send_some(view)
            view = view[sent:]
            if view and not select.select([], [self._sending], [], self._left(until))[1]:
                raise BackendDied(f"{self.called}: takes nothing more: it hangs, or reads too slowly")

    def send_some(self, data: bytes | memoryview) -> int:
        """Send what goes at once, and return how many bytes that were. Raises BackendDied."""
        try:
            return os.write(self._sending, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self.ended(error.strerror or str(error)) from None

    def receive(self, most: int, until: float | None) -> bytes:
        """Return up to so many bytes as soon as there are some; b"" at once where `until` is None and there are none.

        Raises BackendDied where none come before a time of `time.monotonic`, and where the peer has ended.
        """
        wait = 0.0 if until is None else self._left(until)
        if not select.select([self._receiving], [], [], wait)[0]:
            if until is None:
                return b""
            raise TimeoutError
        try:
            data = os.read(self._receiving, most)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self.ended(error.strerror or str(error)) from None
        if not data:
            raise self.ended("it closed the connection")
        return data

    def ended(self, why: str) -> BackendDied:
        """Return the error of a peer that is gone."""
        return BackendDied(f"{self.called}: {why}")

    def close(self) -> None:
        """Close all, and end a program that was started here."""
        self._closing.close()

    @staticmethod
    def _left(until: float) -> float:
        return max(0.0, until - time.monotonic())


def check_program(path: Path, called: str, sha256: str | None) -> None:
    """Raise CdprError where a program is not there, or not the one that a scenario trusts by its checksum."""
    if sha256 != (found := hashlib.sha256(_content(path, called)).hexdigest()):
        text = "has another checksum than the scenario says" if sha256 else "is not trusted to run"
        raise CdprError(f"{called}: {text}: look at it, and if it may run, write sha256: {found}")


class Program(Transport):
    """A program that talks through its standard input and output; its stderr is kept for messages."""

    def __init__(self, path: Path, called: str, sha256: str | None) -> None:
        words = [sys.executable, str(path)] if path.suffix == ".py" else [str(path)]
        check_program(path, called, sha256)
        stack = contextlib.ExitStack()
        try:
            self._process = subprocess.Popen(
                words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=path.parent
            )
        except OSError as error:
            raise CdprError(f"{called}: cannot be started: {error.strerror}") from None
        stack.callback(self._end)
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        self._said, self._errors = b"", process.stderr.fileno()
        os.set_blocking(self._errors, False)
        super().__init__(called, process.stdout.fileno(), process.stdin.fileno(), stack)

    def receive(self, most: int, until: float | None) -> bytes:
        """Do so, and meanwhile take what it says on stderr out of its pipe: it would wait where that is full."""
        while until is not None and self._errors >= 0:
            ready = select.select([self._receiving, self._errors], [], [], self._left(until))[0]
            if self._errors in ready:
                self._listen()
            if self._receiving in ready or not ready:
                break
        return super().receive(most, until)

    def ended(self, why: str) -> BackendDied:
        """Tell how it ended, and its last words."""
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(GRACE)
            why = f"it was killed by signal {-code}" if code < 0 else f"it ended with code {code}"
        self._listen()
        words = self._said.decode(errors="replace").strip()
        return super().ended(f"{why}; its last words: {words[-SHOWN:]}" if words else why)

    def _listen(self) -> None:
        with suppress(BlockingIOError):
            while data := os.read(self._errors, 65536) if self._errors >= 0 else b"":
                self._said = (self._said + data)[-4 * SHOWN :]
            self._errors = -1  # it says no more

    def _end(self) -> None:
        process = self._process
        for pipe in (process.stdin, process.stdout, process.stderr):
            assert pipe is not None
            with suppress(OSError):
                pipe.close()
        try:
            process.wait(GRACE)
        except subprocess.TimeoutExpired:
            process.kill()  # also one that is stopped
            process.wait()


def connected(address: str, called: str, until: float) -> Transport:
    """Return the connection to who listens at HOST:PORT or unix:PATH, tried until a time of `time.monotonic`.

    Raises CdprError for what is no address, BackendDied where nobody answers there.
    """
    kind, place = parsed(address, called)
    while True:
        made = socket.socket(kind, socket.SOCK_STREAM)
        try:
            made.settimeout(max(RETRY, until - time.monotonic()))
            made.connect(place)
            break
        except OSError as error:
            made.close()
            if time.monotonic() >= until:
                raise BackendDied(f"{called}: nobody answers there ({error.strerror or error})") from None
            time.sleep(RETRY)
    if kind == socket.AF_INET:
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # a frame is not to wait for the next
    stack = contextlib.ExitStack()
    stack.callback(made.close)
    return Transport(called, made.fileno(), made.fileno(), stack)


def parsed(address: str, called: str) -> tuple[socket.AddressFamily, str | tuple[str, int]]:
    """Return the kind of a socket and its place. Raises CdprError for what is no address."""
    if address.startswith("unix:"):
        return socket.AF_UNIX, address.removeprefix("unix:")
    host, _, port = address.rpartition(":")
    if not host or not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise CdprError(f"{called}: HOST:PORT, with a port from 1 to 65535, or unix:PATH is expected")
    return socket.AF_INET, (host, int(port))


def _content(path: Path, called: str) -> bytes:
    try:
        if not path.is_file():
            raise CdprError(f"{called}: there is no such file")
        if path.stat().st_size > MOST_BYTES:
            raise CdprError(f"{called}: is larger than {MOST_BYTES // 2**20} MiB: name a small program that starts it")
        return path.read_bytes()
    except OSError as error:
        raise CdprError(f"{called}: cannot be read: {error.strerror}") from None
