"""Client of a peer: greeting, then frames in lock-step or free-running with the newest answer."""

from __future__ import annotations

import json
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.errors import BackendDied
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.cables import commands_of, exits_of
from cdpr.link.options import PeerOptions
from cdpr.link.transport import Program, Transport, check_program, connected, parsed
from cdpr.model.robot import Array, Robot

VERSION = 1
MOST_GREETING = 65536  # bytes
MOST_FRAMES = 2**53  # largest whole number that a float counts to
NUMBER = np.dtype("<f8")


def called_of(options: PeerOptions, program: Path | None) -> str:
    """Return the name of a peer in messages."""
    return f"peer '{options.address if program is None else program.name}'"


def check_peer(options: PeerOptions, program: Path | None) -> None:
    """Raise CdprError if a program may not be started or an address is invalid, before anything runs."""
    if program is not None:
        check_program(program, called_of(options, program), options.sha256)
    else:
        assert options.address is not None
        parsed(options.address, called_of(options, program))


def greeting_of(role: str, robot: Robot, gravity: Array) -> dict[str, Any]:
    """Return the description of a robot for the greeting, SI units."""
    return {
        "role": role,
        "robot": robot.name,
        "dof": list(robot.dof),
        "cables": [cable.name for cable in robot.cables],
        "tension_min": robot.tension_min.tolist(),
        "tension_max": np.minimum(robot.tension_max, MAX_MAGNITUDE).tolist(),
        "mass": robot.platform.mass,
        "inertia": robot.platform.inertia.tolist(),
        "center_of_mass": robot.platform.center_of_mass.tolist(),
        "anchors": robot.anchors.tolist(),
        "unilateral": robot.unilateral,
        "exits": list(exits_of(robot)),
        "commands": commands_of(robot),
        "gravity": gravity.tolist(),
    }


class Peer:
    """Peer of one run.

    Args:
        options: address and time limits.
        program: file to start; None if the peer listens at an address.
        greeting: plain data for the peer; version, time-out and frame lengths are added.
        sends, takes: numbers per frame to and from the peer, without the sequence number.

    Raises:
        CdprError: if the options are invalid.
        BackendDied: if the peer does not start or greet correctly.
    """

    def __init__(
        self, options: PeerOptions, program: Path | None, greeting: dict[str, Any], sends: int, takes: int
    ) -> None:
        self._options = options
        self._out, self._in = np.zeros(sends + 1, NUMBER), np.zeros(takes + 1, NUMBER)
        self._size, self._held = self._in.nbytes, b""
        self._late = b""  # rest of a partly sent frame
        self._sent, self._answered = 0, -1
        self.skipped = 0  # frames that a free-running peer did not receive
        until = time.monotonic() + options.start_timeout
        self.called = called = called_of(options, program)
        if program is None:
            assert options.address is not None
            self._transport: Transport = connected(options.address, called, options.start_timeout)
        else:
            self._transport = Program(program, called, options.sha256)
        greeting = {"cdpr": VERSION, **greeting, "timeout": options.timeout, "sends": sends + 1, "takes": takes + 1}
        try:
            self._greet(greeting, until)
        except BaseException:  # also an interrupt: nobody else could close the peer
            self.close()
            raise
        self._at = time.monotonic()  # time of the newest answer

    def request(self, values: Array) -> Array:
        """Send a frame and return its answer, (takes,), a view.

        Raises:
            BackendDied: if the answer is late, or an answer arrived before its frame was sent.
        """
        self._take_arrived()
        until = time.monotonic() + self._options.timeout
        self._transport.send(self._next(values), until)
        while len(self._held) < self._size:
            try:
                self._held += self._transport.receive(self._size - len(self._held), until)
            except TimeoutError:
                raise self._silent(f"to frame {self._sent - 1}") from None
        self._take()
        if self._answered != self._sent - 1:
            raise self._wrong(f"expected an answer to frame {self._sent - 1}, got one to frame {self._answered}")
        return self._in[1:]

    def newest(self, values: Array) -> Array:
        """Send a frame if the peer accepts it immediately, and return its newest answer, (takes,), a view.

        The first call waits for the answer.

        Raises:
            BackendDied: if the newest answer is older than the time-out.
        """
        if self._sent == 0:
            return self.request(values)
        self._take_arrived()
        if self._late:
            self._late = self._late[self._transport.send_some(self._late) :]
        if self._late:
            self.skipped += 1
        else:
            frame = self._next(values)
            sent = self._transport.send_some(frame)
            self._late = frame[sent:] if sent else b""
            self._sent -= not sent
            self.skipped += not sent
        self._take_arrived()
        if time.monotonic() - self._at > self._options.timeout:
            raise self._silent("lately")
        return self._in[1:]

    def _take_arrived(self) -> None:
        """Read the answers that have arrived.

        Raises:
            BackendDied: if the peer sent more answers than frames.
        """
        while True:
            due = (self._sent - 1 - self._answered) * self._size - len(self._held)
            data = self._transport.receive(due + 1, None)  # bounded: the peer may send without end
            if not data:
                return
            if len(data) > due:
                raise self._wrong(f"answered before frame {self._sent} was sent: each answer must follow its frame")
            self._held += data
            while len(self._held) >= self._size:
                before = self._answered
                self._take()
                if not before < self._answered < self._sent:
                    raise self._wrong(f"answered frame {self._answered} after {before}, of {self._sent}")

    def send(self, values: Array) -> None:
        """Send a last frame without an answer, unless a partial frame is pending or the peer is gone."""
        with suppress(BackendDied):
            if not self._transport.cut:
                self._transport.send(self._next(values), time.monotonic() + self._options.timeout)
                self._sent -= 1

    def close(self) -> None:
        """Close the connection and end a program that was started here."""
        self._transport.close(owed=self._answered < self._sent - 1)

    def _next(self, values: Array) -> bytes:
        self._out[0], self._out[1:] = self._sent, values
        self._sent += 1
        return self._out.tobytes()

    def _take(self) -> None:
        """Parse one received frame and check it."""
        self._in[:] = np.frombuffer(self._held, NUMBER, len(self._in))
        self._held = self._held[self._size :]
        self._at = time.monotonic()
        if not np.isfinite(self._in).all():
            where = int(np.argmin(np.isfinite(self._in)))
            raise self._wrong(f"number {where} of its answer to frame {self._answered + 1} is {self._in[where]}")
        if not 0 <= self._in[0] == int(self._in[0]) <= MOST_FRAMES:
            text = f"sequence: expected the number of a frame, got {self._in[0]}: send little-endian 64-bit floats"
            raise self._wrong(text)
        self._answered = int(self._in[0])

    def _greet(self, greeting: dict[str, Any], until: float) -> None:
        self._transport.send(json.dumps(greeting).encode() + b"\n", until)
        line = b""
        while not line.endswith(b"\n"):
            try:
                line += self._transport.receive(1, until)
            except TimeoutError:
                time_out = f"within start_timeout, {self._options.start_timeout:g} s"
                raise self._wrong(f"did not answer the greeting by a line of JSON {time_out}") from None
            if len(line) > MOST_GREETING:
                raise self._wrong(f"its greeting is longer than {MOST_GREETING} bytes")
        try:
            answer = json.loads(line)
            version = answer["cdpr"]
        except (ValueError, TypeError, KeyError, RecursionError):
            raise self._wrong(f'greets with {line[:80]!r}; expected {{"cdpr": {VERSION}}} and a new line') from None
        if version != VERSION:
            raise self._wrong(f"speaks version {version!r:.40} of the protocol, not {VERSION}")

    def _silent(self, when: str) -> BackendDied:
        return BackendDied(
            f"{self._transport.called}: no answer {when} within the time-out, {self._options.timeout:g} s: "
            "it hangs, is stopped or too slow"
        )

    def _wrong(self, text: str) -> BackendDied:
        return BackendDied(f"{self._transport.called}: {text}")
