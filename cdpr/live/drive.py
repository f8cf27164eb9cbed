"""The loop of a live simulation: slice by slice, paced by the wall clock, with what is asked for done between two."""

from __future__ import annotations

import queue
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Event
from time import monotonic
from typing import Any, Protocol

from cdpr.errors import CdprError
from cdpr.log.run import Header, Run
from cdpr.log.run_folder import RunFolder
from cdpr.model.robot import Array
from cdpr.problems import shown
from cdpr.scenario import Scenario
from cdpr.scenario.events.loads import Wrench
from cdpr.simulation.simulation import Simulation

WAITS = 0.2  # s, at most, between two looks at what was asked for while it stands still
MOVE = 2.0  # s, of a move to a target that says no other


@dataclass
class Request:
    """Something that was asked for from outside.

    Attributes:
        what: a key of `REQUESTS`.
        values: what it needs.
        done: set when it was done, or refused.
        answer: "" or why it was refused.
    """

    what: str
    values: dict[str, Any] = field(default_factory=dict)
    done: Event = field(default_factory=Event)
    answer: str = ""


class Link(Protocol):
    """What shows a simulation to others, and hears them.

    Attributes:
        requests: what was asked for, also before the simulation begins, and is not done yet.
    """

    requests: queue.SimpleQueue[Request]

    def begin(self, header: Header) -> None:
        """Take what is shown."""
        ...

    def show(self, row: Array, sample: int) -> None:
        """Take the newest sample, a copy; it is sent elsewhere."""
        ...

    def refused(self, text: str) -> None:
        """Tell who asked for something that cannot be."""
        ...


class Driven(Simulation):
    """A simulation that goes on slice by slice, and does what is asked for."""

    def __init__(self, scenario: Scenario, out: RunFolder | str | None, link: Link, speed: float, rate: float) -> None:
        super().__init__(scenario, out=out)
        self.paused = False
        self._link, self._slice = link, max(1.0 / rate, scenario.simulation.control_step)
        self._speed = speed
        self._push: Wrench | None = None
        self._tension: list[float] | None = None
        self._from = monotonic(), 0.0

    def drive(self, progress: Callable[[int, int], None]) -> Run:
        """Go on to the end; `progress` is called after each slice, and may raise Interrupted."""
        with self._kept():
            self._link.begin(self.so_far().header)
            self._begin_clock()
            shown = 0.0
            while not self.done:
                progress(self.samples, self.steps + 1)
                self._serve()
                if self.paused:
                    if self.samples:  # who comes meanwhile sees where it stands
                        self._link.show(self.row, self.samples - 1)
                    continue
                self._advance(self.time + self._slice)
                # In real time all are shown, of a run that is faster as many a second.
                if self._speed <= 1.0 or monotonic() - shown >= self._slice:
                    shown = monotonic()
                    self._link.show(self.row, self.samples - 1)
            self._link.show(self.row, self.samples - 1)
        return self.run()

    def _advance(self, time: float) -> None:
        """Go on to a time; with tensions that are given, in place of the solver's."""
        if self._tension is None:
            self.until(time)
            return
        steps = round((time - self.time) / self.scenario.simulation.control_step)
        self.step(max(1, steps), tension=self._tension)

    def _begin_clock(self) -> None:
        self._from = monotonic(), self.time

    def _serve(self) -> None:
        """Wait until the next slice is due, and do what is asked for meanwhile."""
        requests = self._link.requests
        while True:
            begun, time = self._from
            ahead = WAITS if self.paused else (self.time - time) / self._speed - (monotonic() - begun)
            if ahead <= 0.0:
                break
            try:
                self._answer(requests.get(timeout=ahead))
            except queue.Empty:
                break
        for _ in range(requests.qsize()):  # no more: whoever asks without end does not hold it up
            self._answer(requests.get_nowait())
        if not self.paused and ahead < -1.0:  # it is slower than the clock: do not catch up in a rush later
            self._begin_clock()

    def _answer(self, request: Request) -> None:
        try:
            REQUESTS[request.what](self, **request.values)
        except CdprError as error:
            request.answer = str(error)
            self._link.refused(f"{request.values.get('key', request.what)}: {error}")
        request.done.set()

    def ask_pause(self, paused: bool = True) -> None:
        """Stand still, or go on."""
        self.paused = paused
        self._begin_clock()

    def ask_step(self, steps: int = 1) -> None:
        """Take some control steps, and stand still."""
        self.ask_pause()
        self.step(steps) if self._tension is None else self.step(steps, tension=self._tension)
        self._link.show(self.row, self.samples - 1)

    def ask_speed(self, speed: float) -> None:
        """Go so many times as fast as the wall clock."""
        if not 0.0 < speed < float("inf"):
            raise CdprError(f"a number greater than 0 is expected, got {speed!r}")
        self._speed = speed
        self._begin_clock()

    def ask_target(self, position: list[float], orientation: list[float], duration: float = MOVE) -> None:
        """Let the desired motion go to another pose, quaternion w, x, y, z."""
        self.target(position, orientation, duration=duration)

    def ask_wrench(self, force: list[float], moment: list[float]) -> None:
        """Let this wrench act from now on, in place of the one before."""
        made = self.push(force, moment)
        if self._push is not None:
            self.release(self._push)
        self._push = made

    def ask_tension(self, tension: list[float], names: list[str] | None = None) -> None:
        """Tell the cables these tensions, N, from now on; none at all gives them back to the controller.

        They are in the order of the cables, or of `names`.
        """
        if not tension:
            self._tension = None
            return
        if names:
            cables = self.so_far().header.cables
            if sorted(names) != sorted(cables) or len(tension) != len(names):
                raise CdprError(
                    f"one for each of {', '.join(cables)} is expected, got {shown(names)}, {len(tension)} tensions"
                )
            tension = [tension[names.index(cable)] for cable in cables]
        self._given(None, tension)  # refused at once where it makes no sense
        self._tension = tension

    def ask_stop(self) -> None:
        """Stop the robot as in an emergency."""
        self.stop()

    def ask_set(self, key: str, value: Any) -> None:
        """Give an option of controller or solver another value."""
        self.set(key, value)

    def ask_reset(self) -> None:
        """Begin anew, where nothing is logged."""
        self.reset()
        self._push, self._tension = None, None
        self._begin_clock()


REQUESTS: dict[str, Callable[..., None]] = {
    name.removeprefix("ask_"): method for name, method in vars(Driven).items() if name.startswith("ask_")
}


def drive(
    scenario: Scenario,
    link: Link,
    *,
    out: RunFolder | str | None = None,
    speed: float = 1.0,
    rate: float = 60.0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Run:
    """Simulate a scenario while others look on and steer, and return the run.

    Args:
        scenario: as loaded.
        link: what shows it, and hears.
        out: folder for the log, likewise as `cdpr.simulate` has it; without one, it can be reset.
        speed: so many times as fast as the wall clock, at most.
        rate: of what is shown, Hz of simulated time.
        progress: called with the number of samples and their total; may raise Interrupted.

    Raises what `cdpr.simulate` does.
    """
    return Driven(scenario, out, link, speed, rate).drive(progress)
