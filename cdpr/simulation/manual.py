"""Manual control: commands of the cables by requests, in place of the controller.

Requests change the commands of single cables. All other winches keep their last command; those that take rates stop.
The simulation records the commands of each step, so that a saved session repeats them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.fields import MAX_MAGNITUDE, MAX_UNWOUND
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.cables import LENGTH, RATE, TENSION, commands_of, takes_lengths
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.simulation.arguments import in_order
from cdpr.simulation.simulation import Simulation

STOPPED = "the robot is stopped"


@dataclass(frozen=True)
class CableRequest:
    """Requested command of a cable.

    Attributes:
        length: unwound length, m; with `rate` the end of a move, without it commanded at once.
        rate: rate of the unwound length, m/s, until the next request; with `length` only its magnitude counts.
        tension: tension, N, of a winch that takes tensions.
    """

    length: float | None = None
    rate: float | None = None
    tension: float | None = None


class ManualControl:
    """Commands that replace those of the controller, until it has control again.

    Args:
        simulation: simulation that takes the commands.
        warn: called with a text if a winch stops at the end of its range.
    """

    def __init__(self, simulation: Simulation, warn: Callable[[str], None]) -> None:
        robot = self._robot = simulation.scenario.robot
        self._simulation, self._warn = simulation, warn
        self._period = simulation.scenario.simulation.control_step
        self._names = [cable.name for cable in robot.cables]
        self._takes = commands_of(robot)
        self.release()

    def release(self) -> None:
        """Return control to the controller."""
        self._tension: list[float] | None = None  # of all cables, converted for other winches
        self._active = False
        self._pending: dict[int, CableRequest] = {}  # that begin with the next step
        self._command: Array | None = None  # (m,), in the units of the winches
        self._moves: dict[int, CableRequest] = {}
        self._unwound: dict[int, float] = {}  # commanded unwound lengths of moving winches, m

    @property
    def active(self) -> bool:
        """True if the controller has no control of the winches."""
        return self._active or self._tension is not None

    def tensions(self, tension: Sequence[float], names: Sequence[str] | None = None) -> None:
        """Command these tensions, N, of all cables, in their order or that of `names`; none return the control.

        Raises:
            CdprError: if they are invalid, or the robot is stopped.
        """
        if not len(tension):
            self.release()
            return
        self._check_running("tension")
        if names:
            tension = in_order(tension, names, self._names)
        checked(tension, (len(self._names),), "tension", finite=True)  # refuse invalid values immediately
        self.release()
        self._tension = list(tension)

    def command(self, title: str, requests: Iterable[tuple[str | int, CableRequest]]) -> None:
        """Change the commands of these cables, given by name or number from 1.

        Raises:
            CdprError: if a winch does not take its command, or a value is invalid; then nothing changes.
        """
        self._check_running(title)
        found = {self._index(title, cable): request for cable, request in requests}
        for i, request in found.items():
            self._check(f"{title}: cable '{self._names[i]}'", self._takes[i], request)
        if self._tension is not None:
            self.release()
        self._active = True
        self._pending |= found

    def hold(self) -> None:
        """Stop all winches that take lengths or rates.

        Raises:
            CdprError: if the robot has none, or is stopped.
        """
        still = [i for i, takes in enumerate(self._takes) if takes != TENSION]
        if not still:
            raise CdprError("hold: all winches of this robot take tensions, and hold no length")
        self.command("winches", [(i + 1, CableRequest(rate=0.0)) for i in still])

    def step(self, n: int) -> None:
        """Take n control steps, or those that remain, with these commands, until a stop of the robot."""
        simulation = self._simulation
        if self.active:
            taken = min(n, simulation.steps_before_stop)
            if taken:
                self._take(int(taken))
            n -= int(taken)
            if not n:
                return
            self.release()
        simulation.step(n)

    def _take(self, n: int) -> None:
        """Take n steps before a stop."""
        simulation = self._simulation
        if self._tension is not None:
            simulation.step(n, tension=self._tension)
            return
        if not simulation.samples:  # there is no command to keep yet
            simulation.step()
            n -= 1
        while n and not simulation.done:
            command = self._next()
            steps = 1 if self._moves else n
            simulation.step(steps, command=command)
            n -= steps

    def _next(self) -> Array:
        """Return the commands (m,) of the next step."""
        command = self._command
        if command is None:
            command = self._command = self._last("winch_command" if takes_lengths(self._robot) else "tension")
            command[[takes == RATE for takes in self._takes]] = 0.0
        for i, request in self._pending.items():
            self._begin(command, i, request)
        self._pending.clear()
        for i in [*self._moves]:
            self._move(command, i, self._moves[i])
        return command

    def _begin(self, command: Array, i: int, request: CableRequest) -> None:
        """Begin what is requested of a cable."""
        self._moves.pop(i, None)
        if self._takes[i] == RATE:
            command[i] = 0.0
        if request.tension is not None:
            command[i] = request.tension
        elif request.rate is None:
            command[i] = request.length
        elif request.rate:
            self._moves[i] = request
            start = command if self._takes[i] == LENGTH else self._last("unstretched_length")
            self._unwound[i] = float(start[i])

    def _last(self, column: str) -> Array:
        """Return the values (m,) of a column in the last sample."""
        simulation = self._simulation
        return simulation.row[simulation.header.layout.columns[column]]

    def _move(self, command: Array, i: int, request: CableRequest) -> None:
        """Wind a cable for one step, and end its move where it is complete."""
        before, rate = self._unwound[i], request.rate
        assert rate is not None
        if request.length is not None:
            rate = math.copysign(rate, request.length - before)
        after = before + rate * self._period
        complete = request.length is not None and abs(request.length - before) <= abs(rate) * self._period
        if complete:
            assert request.length is not None
            after = request.length
        if not 0.0 < after <= MAX_UNWOUND:
            self._warn(
                f"cable '{self._names[i]}': the winch stops at an unwound length of {before:g} m: the length must "
                f"be greater than 0 and at most {MAX_UNWOUND:g} m"
            )
            after, complete = before, True
        self._unwound[i] = after
        if self._takes[i] == LENGTH:
            command[i] = after
        else:
            command[i] = (after - before) / self._period if complete else rate
            complete = not command[i]  # a rate of 0 follows the last step
        if complete:
            del self._moves[i]

    def _check_running(self, title: str) -> None:
        if not self._simulation.steps_before_stop:
            raise CdprError(f"{title}: {STOPPED}")

    def _index(self, title: str, cable: Any) -> int:
        if cable in self._names:
            return self._names.index(cable)
        if type(cable) is int and 1 <= cable <= len(self._names):
            return cable - 1
        near = did_you_mean(cable, self._names) if isinstance(cable, str) else ""
        raise CdprError(f"{title}: unknown cable {shown(cable)}: {near}allowed: {', '.join(self._names)}")

    def _check(self, where: str, takes: str, request: CableRequest) -> None:
        """Raise CdprError if a winch with this command does not take a request, or a value is invalid."""
        length, rate, tension = request.length, request.rate, request.tension
        for name, value in (("length", length), ("rate", rate), ("tension", tension)):
            if value is not None and not (type(value) in (int, float) and abs(value) <= MAX_MAGNITUDE):
                raise CdprError(
                    f"{where}: {name}: expected a number of at most {MAX_MAGNITUDE:g} in size, got {shown(value)}"
                )
        if takes == TENSION:
            allowed = tension is not None and length is None and rate is None
            expected = "a tension (N)"
        else:
            allowed = tension is None and (rate is not None or (length is not None and takes == LENGTH))
            expected = (
                "a rate (m/s), a length (m), or both" if takes == LENGTH else "a rate (m/s), or with it a length (m)"
            )
        if not allowed:
            given = [name for name, value in vars(request).items() if value is not None]
            raise CdprError(f"{where}: its winch takes {expected}, got {' and '.join(given) or 'nothing'}")
        if length is not None and not 0.0 < length <= MAX_UNWOUND:
            raise CdprError(f"{where}: length: expected more than 0 and at most {MAX_UNWOUND:g} m, got {length:g}")
        if length is not None and rate is not None and not rate:
            raise CdprError(f"{where}: rate: a move to a length needs a rate other than 0 m/s")


def cable_requests(
    names: Sequence[str],
    length: Sequence[float | None],
    rate: Sequence[float | None],
    tension: Sequence[float | None],
    cables: Sequence[str],
) -> list[tuple[str | int, CableRequest]]:
    """Return the requests of single cables in lists of their values.

    Args:
        names: cables of the values; empty for all, in order.
        length: m, None where there is none; an empty list for none at all.
        rate: m/s, likewise.
        tension: N, likewise.
        cables: names of all cables.

    Raises:
        CdprError: if the numbers of names and values differ, or a name occurs twice.
    """
    names = names or cables
    for name, values in (("position", length), ("velocity", rate), ("effort", tension)):
        if len(values) not in (0, len(names)):
            raise CdprError(f"{name}: expected no value or {len(names)}, one for each cable, got {len(values)}")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise CdprError(f"name: {shown(twice)} occurs twice")
    nothing = [None] * len(names)
    rows = zip(names, length or nothing, rate or nothing, tension or nothing, strict=True)
    return [(name, CableRequest(*values)) for name, *values in rows]
