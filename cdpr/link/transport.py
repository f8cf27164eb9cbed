"""Byte transport to and from a peer: pipes of a program started here, or a socket."""

from __future__ import annotations

import errno
import hashlib
import os
import select
import signal
import socket
import subprocess
import sys
import time
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path

from cdpr.base.errors import BackendDied, CdprError
from cdpr.base.interrupts import WAITING, uninterrupted
from cdpr.link.waiting import report_wait

MOST_BYTES = 16 * 2**20  # largest program
RETRY = 0.02  # s between two attempts to connect
GRACE = 1.0  # s that a peer has to exit after its input ends
LOOK = 0.01  # s between two checks whether child processes of a program have ended
SHOWN = 2000  # characters of a program's last stderr output in messages
CHUNK = 65536  # bytes of stderr per read
REMEDIES = {
    errno.EACCES: "'chmod +x' makes a file a program",
    errno.ENOEXEC: "a script begins with #! and its interpreter, such as #!/usr/bin/perl",
    errno.ENOENT: "the interpreter behind its #! is not there",
}
FULL = 2**20 // CHUNK  # chunks in the largest pipe; more were written in the meantime, possibly without end
MOST_PATH = 107  # bytes of a socket's path


class Transport(ABC):
    """Pair of non-blocking descriptors.

    Attributes:
        called: name of the peer in messages.
        cut: True if `send` sent only a part.
    """

    def __init__(self, called: str, receiving: int, sending: int) -> None:
        self.called, self.cut = called, False
        self._receiving, self._sending, self._open = receiving, sending, True
        for descriptor in {receiving, sending}:
            os.set_blocking(descriptor, False)

    def send(self, data: bytes, until: float) -> None:
        """Send all data before a time of `time.monotonic`.

        Raises:
            BackendDied: if the peer does not accept it in time, or is gone.
        """
        view = memoryview(data)
        while view:
            view = view[self.send_some(view) :]
            self.cut = 0 < len(view) < len(data)
            if view and not ready([], [self._sending], until):
                raise BackendDied(f"{self.called}: accepts no more data: it hangs, or reads too slowly")

    def send_some(self, data: bytes | memoryview) -> int:
        """Send as many bytes as possible without waiting, and return their number.

        Raises:
            BackendDied: if the peer is gone.
        """
        try:
            return os.write(self._sending, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self.ended(error.strerror or str(error)) from None

    def receive(self, most: int, until: float | None) -> bytes:
        """Return up to `most` bytes as soon as some are available.

        If `until` is None, return b"" immediately when none are.

        Raises:
            TimeoutError: if none arrive before `until`, a time of `time.monotonic`.
            BackendDied: if the peer has ended.
        """
        if not ready([self._receiving], [], until):
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
        """Return the error for a peer that is gone."""
        return BackendDied(f"{self.called}: {why}")

    def close(self, owed: bool) -> None:
        """Close the transport and end a program started here; `owed` is True if an answer is pending."""
        if self._open:
            self._open = False
            with uninterrupted():
                self._end(owed)

    @abstractmethod
    def _end(self, owed: bool) -> None:
        """Close descriptors and end processes."""


def ready(reading: list[int], writing: list[int], until: float | None) -> list[int]:
    """Return the readable and writable descriptors; wait until a time of `time.monotonic`, or not if None."""
    with WAITING:
        found = select.select(reading, writing, [], 0.0 if until is None else max(0.0, until - time.monotonic()))
    return [*found[0], *found[1]]


def check_program(path: Path, called: str, sha256: str | None) -> None:
    """Raise CdprError if a program is missing or does not have the trusted checksum."""
    if sha256 != (found := hashlib.sha256(_content(path, called)).hexdigest()):
        text = "its checksum differs from the one in the scenario" if sha256 else "is not trusted to run"
        raise CdprError(f"{called}: {text}: inspect it, and if you trust it, write sha256: {found}")


def _remedy(error: OSError) -> str:
    """Return the remedy for a program that cannot be started."""
    return f": {remedy}" if (remedy := REMEDIES.get(error.errno or 0)) else ""


class Program(Transport):
    """Program that communicates through standard input and output; its stderr is kept for messages.

    It has its own process group: Ctrl-C in a terminal reaches only cdpr, which then stops the program. Its child
    processes end with it.
    """

    def __init__(self, path: Path, called: str, sha256: str | None) -> None:
        words = [sys.executable, str(path)] if path.suffix == ".py" else [str(path)]
        check_program(path, called, sha256)
        try:
            self._process = subprocess.Popen(
                words,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                cwd=path.parent,
                process_group=0,
            )
        except OSError as error:
            raise CdprError(f"{called}: cannot be started: {error.strerror}{_remedy(error)}") from None
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        self._captured, self._errors = b"", process.stderr.fileno()
        os.set_blocking(self._errors, False)
        super().__init__(called, process.stdout.fileno(), process.stdin.fileno())

    def receive(self, most: int, until: float | None) -> bytes:
        """Receive data, and also read stderr: the program would block if that pipe were full."""
        if until is None:
            self._listen()
        while until is not None and self._errors >= 0:
            found = ready([self._receiving, self._errors], [], until)
            if self._errors in found:
                self._listen()
            if self._receiving in found or not found or time.monotonic() >= until:  # it may write without end
                break
        return super().receive(most, until)

    def ended(self, why: str) -> BackendDied:
        """Return the error with the exit status and the last output."""
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(GRACE)
            why = f"it was killed by signal {-code}" if code < 0 else f"it ended with code {code}"
        self._listen(FULL)
        words = self._captured.decode(errors="replace").strip()
        return super().ended(f"{why}; its last words: {words[-SHOWN:]}" if words else why)

    def _listen(self, most: int = 1) -> None:
        """Read up to `most` chunks of stderr."""
        with suppress(BlockingIOError):
            for _ in range(most if self._errors >= 0 else 0):
                if not (data := os.read(self._errors, CHUNK)):
                    self._errors = -1  # end of its output
                    return
                self._captured = (self._captured + data)[-4 * SHOWN :]

    def _end(self, owed: bool) -> None:
        process, until = self._process, time.monotonic() + GRACE
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        with suppress(OSError):
            process.stdin.close()
        drain_output([process.stdout.fileno(), process.stderr.fileno()], until)
        with suppress(subprocess.TimeoutExpired):
            process.wait(max(0.0, until - time.monotonic()))
        with suppress(OSError):  # no process of the group is left
            while time.monotonic() < until:
                os.killpg(process.pid, 0)
                time.sleep(LOOK)
            os.killpg(process.pid, signal.SIGKILL)  # ends stopped processes, too
        process.wait()
        process.stdout.close()
        process.stderr.close()


class Connection(Transport):
    """Socket connection to a listening peer."""

    def __init__(self, connection: socket.socket, called: str) -> None:
        super().__init__(called, connection.fileno(), connection.fileno())
        self._socket = connection

    def _end(self, owed: bool) -> None:
        with self._socket, suppress(OSError):
            if owed:  # unread data at the close could discard data on its way to the peer
                self._socket.shutdown(socket.SHUT_WR)
                drain_output([self._socket.fileno()], time.monotonic() + GRACE)


def drain_output(descriptors: list[int], until: float) -> None:
    """Discard further input until the end, so that a stopping peer does not fail while it answers."""
    while descriptors and time.monotonic() < until:
        for each in ready(descriptors, [], until):
            with suppress(BlockingIOError):
                try:
                    if os.read(each, CHUNK):
                        continue
                except ConnectionError:
                    pass
                descriptors.remove(each)


def connected(address: str, called: str, start_timeout: float) -> Transport:
    """Return a connection to the peer at HOST:PORT or unix:PATH, with attempts for `start_timeout` s.

    Raises:
        CdprError: if the address is invalid.
        BackendDied: if no peer answers at the address.
    """
    kind, place = parsed(address, called)
    until, reported = time.monotonic() + start_timeout, False
    with WAITING:
        while True:
            connection = socket.socket(kind, socket.SOCK_STREAM)
            try:
                connection.settimeout(max(RETRY, until - time.monotonic()))
                connection.connect(place)
                break
            except OSError as error:
                connection.close()
                if time.monotonic() >= until:
                    why = f"within start_timeout, {start_timeout:g} s ({error.strerror or error})"
                    raise BackendDied(f"{called}: no connection {why}; start it first") from None
                if not reported:
                    reported = True
                    report_wait(called, start_timeout)
                time.sleep(RETRY)
    if kind == socket.AF_INET:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # send frames without delay
    return Connection(connection, called)


def parsed(address: str, called: str) -> tuple[socket.AddressFamily, str | tuple[str, int]]:
    """Return the family and the address of a socket.

    Raises:
        CdprError: if the address is invalid.
    """
    kind, _, path = address.partition(":")
    if kind == "unix":
        if "\0" in path or not 0 < len(os.fsencode(path)) <= MOST_PATH:
            raise CdprError(f"{called}: the path of a socket must have 1 to {MOST_PATH} bytes, none of them 0")
        return socket.AF_UNIX, path
    host, _, port = address.rpartition(":")
    if not _named(host) or not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise CdprError(f"{called}: expected HOST:PORT, with a port from 1 to 65535, or unix:PATH")
    return socket.AF_INET, (host, int(port))


def _named(host: str) -> bool:
    """Return True if the name is a valid host name."""
    try:
        return bool(host.encode("idna")) and "\0" not in host
    except UnicodeError:
        return False


def _content(path: Path, called: str) -> bytes:
    try:
        if not path.is_file():
            raise CdprError(f"{called}: no such file")
        if path.stat().st_size > MOST_BYTES:
            raise CdprError(f"{called}: is larger than {MOST_BYTES // 2**20} MiB: give a small program that starts it")
        return path.read_bytes()
    except OSError as error:
        raise CdprError(f"{called}: cannot be read: {error.strerror}") from None
