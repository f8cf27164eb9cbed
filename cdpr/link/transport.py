"""Bytes to and from a peer: over the pipes of a program that is started here, or a socket on which it listens."""

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

from cdpr.errors import BackendDied, CdprError
from cdpr.interrupts import WAITING, uninterrupted
from cdpr.link.waiting import tell_wait

MOST_BYTES = 16 * 2**20  # of a program
RETRY = 0.02  # s, between two tries to reach a peer that does not listen yet
GRACE = 1.0  # s, that a peer has to end by itself when its input ends
LOOK = 0.01  # s, between two looks whether what a program started has ended
SHOWN = 2000  # of what a program said last on stderr, characters
CHUNK = 65536  # bytes of stderr that are taken at once
REMEDIES = {
    errno.EACCES: "'chmod +x' makes a file a program",
    errno.ENOEXEC: "a script begins with #! and its interpreter, such as #!/usr/bin/perl",
    errno.ENOENT: "the interpreter behind its #! is not there",
}
FULL = 2**20 // CHUNK  # of them fill the largest pipe: more are said meanwhile, perhaps without end
MOST_PATH = 107  # bytes of the path of a socket


class Transport(ABC):
    """A pair of descriptors that never block.

    Attributes:
        called: what the peer is called in messages.
        cut: whether `send` has sent a part alone.
    """

    def __init__(self, called: str, receiving: int, sending: int) -> None:
        self.called, self.cut = called, False
        self._receiving, self._sending, self._open = receiving, sending, True
        for descriptor in {receiving, sending}:
            os.set_blocking(descriptor, False)

    def send(self, data: bytes, until: float) -> None:
        """Send all of it before a time of `time.monotonic`. Raises BackendDied."""
        view = memoryview(data)
        while view:
            view = view[self.send_some(view) :]
            self.cut = 0 < len(view) < len(data)
            if view and not ready([], [self._sending], until):
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
        """Return the error of a peer that is gone."""
        return BackendDied(f"{self.called}: {why}")

    def close(self, owed: bool) -> None:
        """Close all, and end a program that was started here; `owed` is whether an answer is still to come."""
        if self._open:
            self._open = False
            with uninterrupted():
                self._end(owed)

    @abstractmethod
    def _end(self, owed: bool) -> None:
        """Close what was opened, and end what was started here."""


def ready(reading: list[int], writing: list[int], until: float | None) -> list[int]:
    """Return which descriptors can be read or written, waiting until a time of `time.monotonic`; None does not wait."""
    with WAITING:
        found = select.select(reading, writing, [], 0.0 if until is None else max(0.0, until - time.monotonic()))
    return [*found[0], *found[1]]


def check_program(path: Path, called: str, sha256: str | None) -> None:
    """Raise CdprError where a program is not there, or not the one that a scenario trusts by its checksum."""
    if sha256 != (found := hashlib.sha256(_content(path, called)).hexdigest()):
        text = "has another checksum than the scenario says" if sha256 else "is not trusted to run"
        raise CdprError(f"{called}: {text}: look at it, and if it may run, write sha256: {found}")


def _remedy(error: OSError) -> str:
    """What to do about a program that the system does not start."""
    return f": {told}" if (told := REMEDIES.get(error.errno or 0)) else ""


class Program(Transport):
    """A program that talks through its standard input and output; its stderr is kept for messages.

    It is in a process group of its own: Ctrl-C in a terminal is for cdpr, which then tells it to stop, and what it has
    started ends with it.
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
        self._said, self._errors = b"", process.stderr.fileno()
        os.set_blocking(self._errors, False)
        super().__init__(called, process.stdout.fileno(), process.stdin.fileno())

    def receive(self, most: int, until: float | None) -> bytes:
        """Do so, and meanwhile take what it says on stderr out of its pipe: it would wait where that is full."""
        if until is None:
            self._listen()
        while until is not None and self._errors >= 0:
            found = ready([self._receiving, self._errors], [], until)
            if self._errors in found:
                self._listen()
            if self._receiving in found or not found or time.monotonic() >= until:  # it may speak without end
                break
        return super().receive(most, until)

    def ended(self, why: str) -> BackendDied:
        """Tell how it ended, and its last words."""
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(GRACE)
            why = f"it was killed by signal {-code}" if code < 0 else f"it ended with code {code}"
        self._listen(FULL)
        words = self._said.decode(errors="replace").strip()
        return super().ended(f"{why}; its last words: {words[-SHOWN:]}" if words else why)

    def _listen(self, most: int = 1) -> None:
        """Take up to so many chunks of what it says on stderr."""
        with suppress(BlockingIOError):
            for _ in range(most if self._errors >= 0 else 0):
                if not (data := os.read(self._errors, CHUNK)):
                    self._errors = -1  # it says no more
                    return
                self._said = (self._said + data)[-4 * SHOWN :]

    def _end(self, owed: bool) -> None:
        process, until = self._process, time.monotonic() + GRACE
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        with suppress(OSError):
            process.stdin.close()
        hear_out([process.stdout.fileno(), process.stderr.fileno()], until)
        with suppress(subprocess.TimeoutExpired):
            process.wait(max(0.0, until - time.monotonic()))
        with suppress(OSError):  # nothing of the group is left
            while time.monotonic() < until:
                os.killpg(process.pid, 0)
                time.sleep(LOOK)
            os.killpg(process.pid, signal.SIGKILL)  # also those that are stopped
        process.wait()
        process.stdout.close()
        process.stderr.close()


class Connection(Transport):
    """A socket on which a peer listens."""

    def __init__(self, made: socket.socket, called: str) -> None:
        super().__init__(called, made.fileno(), made.fileno())
        self._socket = made

    def _end(self, owed: bool) -> None:
        with self._socket, suppress(OSError):
            if owed:  # what is not read at the end may cost the peer what it was sent last
                self._socket.shutdown(socket.SHUT_WR)
                hear_out([self._socket.fileno()], time.monotonic() + GRACE)


def hear_out(descriptors: list[int], until: float) -> None:
    """Drop what still comes until nothing more can: who is told to stop is not to fail with an answer before that."""
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
    """Return the connection to who listens at HOST:PORT or unix:PATH, tried for so long, s.

    Raises CdprError for what is no address, BackendDied where nobody answers there.
    """
    kind, place = parsed(address, called)
    until, told = time.monotonic() + start_timeout, False
    with WAITING:
        while True:
            made = socket.socket(kind, socket.SOCK_STREAM)
            try:
                made.settimeout(max(RETRY, until - time.monotonic()))
                made.connect(place)
                break
            except OSError as error:
                made.close()
                if time.monotonic() >= until:
                    why = f"within start_timeout, {start_timeout:g} s ({error.strerror or error})"
                    raise BackendDied(f"{called}: nobody answers there {why}; start it first") from None
                if not told:
                    told = True
                    tell_wait(called, start_timeout)
                time.sleep(RETRY)
    if kind == socket.AF_INET:
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # a frame is not to wait for the next
    return Connection(made, called)


def parsed(address: str, called: str) -> tuple[socket.AddressFamily, str | tuple[str, int]]:
    """Return the kind of a socket and its place. Raises CdprError for what is no address."""
    kind, _, path = address.partition(":")
    if kind == "unix":
        if "\0" in path or not 0 < len(os.fsencode(path)) <= MOST_PATH:
            raise CdprError(f"{called}: the path of a socket has from 1 to {MOST_PATH} bytes, none of them 0")
        return socket.AF_UNIX, path
    host, _, port = address.rpartition(":")
    if not _named(host) or not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise CdprError(f"{called}: HOST:PORT, with a port from 1 to 65535, or unix:PATH is expected")
    return socket.AF_INET, (host, int(port))


def _named(host: str) -> bool:
    """Whether a computer may be called so."""
    try:
        return bool(host.encode("idna")) and "\0" not in host
    except UnicodeError:
        return False


def _content(path: Path, called: str) -> bytes:
    try:
        if not path.is_file():
            raise CdprError(f"{called}: there is no such file")
        if path.stat().st_size > MOST_BYTES:
            raise CdprError(f"{called}: is larger than {MOST_BYTES // 2**20} MiB: name a small program that starts it")
        return path.read_bytes()
    except OSError as error:
        raise CdprError(f"{called}: cannot be read: {error.strerror}") from None
