"""Loop of a live simulation: slices paced by the wall clock, with requests processed in between."""

from __future__ import annotations

import math
import queue
from collections.abc import Callable, Mapping
from contextlib import suppress
from time import monotonic
from typing import Any, Protocol

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.header import Header
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.scenario.events.loads import Wrench
from cdpr.simulation.simulation import Simulation
from cdpr.ui.live import RATES, SPEEDS
from cdpr.ui.live.requests import Request, Requests

WAITS = 0.2  # s, longest time between two calls of `progress` while it waits or is paused
LOOKS = 60.0  # Hz of simulated time, lowest rate at which requests are processed
BUSY = 0.001  # s, time limit for requests while a slice is due; further requests wait
SHARE = 0.05  # largest share of the time spent on such requests
MOVE = 2.0  # s, default duration of a move to a target


class Link(Protocol):
    """Interface of a live link: shows a simulation to clients and receives their requests.

    Attributes:
        requests: pending requests, including those from before the simulation.
    """

    requests: Requests

    def begin(self, header: Header) -> None:
        """Start with the description of the run."""
        ...

    def show(self, row: Array, sample: int) -> None:
        """Show the newest sample, a copy; sending is asynchronous."""
        ...

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Report changed parameters."""
        ...

    def refused(self, text: str) -> None:
        """Report a refused request to the clients."""
        ...

    def warned(self, text: str) -> None:
        """Report an accepted but suspicious request to the clients."""
        ...


class Driven(Simulation):
    """Simulation that advances in slices and processes requests."""

    def __init__(self, scenario: Scenario, out: RunFolder | str | None, link: Link, speed: float, rate: float) -> None:
        self._speed = _within("speed", speed, SPEEDS)
        self._period = 1.0 / _within("rate", rate, RATES)
        super().__init__(scenario, out=out)
        self.paused = False
        self._link = link
        # a whole number of slices per period
        self._slice = max(self._period / math.ceil(LOOKS * self._period), scenario.simulation.control_step)
        self._push: Wrench | None = None
        self._doubted = False  # True if the last target caused a warning
        self._tension: list[float] | None = None
        self._begin_clock()
        self._heeds = -math.inf  # clock time from which late requests are processed
        self._shown = -math.inf, -math.inf  # clock time and simulated time of the last shown sample

    def drive(self, progress: Callable[[int, int], None]) -> Run:
        """Simulate to the end; `progress` is called after each slice and may raise Interrupted."""
        with self._kept():
            self._link.begin(self.so_far().header)
            self._link.changed({"paused": self.paused, "speed": self._speed})
            self._begin_clock()
            while not self.done:
                progress(self.samples, self.steps + 1)
                due = self._serve()
                if due and not self.done:
                    self._advance(self.time + self._slice)
                if self._showing(due):
                    self._show()
            self._show()
        return self.run()

    def _advance(self, time: float) -> None:
        """Simulate to a time, s, with the requested tensions instead of the solver's, if any."""
        if self._tension is None:
            self.until(time)
            return
        steps = round((time - self.time) / self.scenario.simulation.control_step)
        self.step(max(1, steps), tension=self._tension)

    def _showing(self, moving: bool) -> bool:
        """Return True if the newest sample must be shown now.

        Samples are shown once per period of simulated time at up to real time, once per period of the clock in faster
        runs, and occasionally while paused, for new clients.
        """
        clock, time = self._shown
        if not moving:
            return monotonic() - clock >= WAITS
        least = self._period * (1.0 - tolerances.TIME)
        return (self.time - time if self._speed <= 1.0 else monotonic() - clock) >= least

    def _show(self) -> None:
        if self.samples:
            self._link.show(self.row, self.samples - 1)
            self._shown = monotonic(), self.time

    def _begin_clock(self, ahead: float = 0.0) -> None:
        """Restart the clock; the next slice is due in `ahead` s."""
        self._from = monotonic() + ahead, self.time

    @property
    def _ahead(self) -> float:
        """Time until the next slice is due, s."""
        begun, time = self._from
        return math.inf if self.paused else (self.time - time) / self._speed - (monotonic() - begun)

    def _serve(self) -> bool:
        """Process requests until the next slice is due, but not for long; return True if it is due."""
        requests, until = self._link.requests, monotonic() + WAITS
        try:
            while not self.done and (wait := min(self._ahead, until - monotonic())) > 0.0:
                self._answer(requests.get(wait))
        except queue.Empty:
            pass
        self._process_requests()
        if self._ahead < -1.0:  # slower than the clock: do not catch up later
            self._begin_clock()
        return self._ahead <= 0.0

    def _process_requests(self) -> None:
        """Process some requests although the slice is due; endless requests must not block the simulation."""
        begun = now = monotonic()
        with suppress(queue.Empty):
            while not self.done and begun >= self._heeds and now - begun <= BUSY:
                self._answer(self._link.requests.get())
                now = monotonic()
        self._heeds = max(self._heeds, now + min((now - begun) / SHARE, WAITS))

    def _answer(self, request: Request) -> None:
        try:
            REQUESTS[request.what](self, **request.values)
        except CdprError as error:
            request.answer = str(error)
            if self._runner.run is not None:  # not a refusal: the run has ended
                raise
            what = request.values.get("key", request.what)
            self._link.refused(f"{what}: {error}" if what != request.answer.partition(":")[0] else request.answer)
        finally:
            request.done.set()

    def request_pause(self, paused: bool = True) -> None:
        """Pause or resume."""
        if self.paused and not paused:
            self._begin_clock()
        self.paused = paused
        self._link.changed({"paused": paused})

    def request_step(self, steps: int = 1) -> None:
        """Simulate some control steps and pause."""
        self.request_pause()
        self.step(steps) if self._tension is None else self.step(steps, tension=self._tension)
        self._show()

    def request_speed(self, speed: float) -> None:
        """Set the speed as a multiple of the wall clock."""
        speed = _within("", speed, SPEEDS)
        if not self.paused:
            self._begin_clock(max(self._ahead, 0.0) * self._speed / speed)
        self._speed = speed
        self._link.changed({"speed": speed})

    def request_target(self, position: list[float], orientation: list[float], duration: float = MOVE) -> None:
        """Move the desired pose of the origin to a target, quaternion w, x, y, z; warn once."""
        self.target(position, orientation, duration=duration)
        doubts = self.scenario.doubts(self.events)
        if doubts and not self._doubted:
            self._link.warned(f"target: {'; '.join(doubts)}")
        self._doubted = bool(doubts)

    def request_wrench(self, force: list[float], moment: list[float]) -> None:
        """Apply this wrench from now on instead of the previous one; zero ends it."""
        if self._push is not None and (list(self._push.force), list(self._push.moment)) == (force, moment):
            return
        push = self.push(force, moment) if any(force + moment) else None
        if self._push is not None:
            self.release(self._push)
        self._push = push

    def request_tension(self, tension: list[float], names: list[str] | None = None) -> None:
        """Command these tensions, N, from now on; an empty list returns control to the controller.

        The order is that of the cables, or of `names`.
        """
        if not tension:
            self._tension = None
            return
        if names:
            cables = self.so_far().header.cables
            if sorted(names) != sorted(cables) or len(tension) != len(names):
                raise CdprError(
                    f"expected one for each of {', '.join(cables)}, got {shown(names)}, {len(tension)} tensions"
                )
            tension = [tension[names.index(cable)] for cable in cables]
        checked(tension, (self.scenario.robot.m,), "tension", finite=True)  # refuse invalid values immediately
        self._tension = tension

    def request_stop(self) -> None:
        """Stop the robot as in an emergency."""
        self.stop()

    def request_set(self, key: str, value: Any) -> None:
        """Set an option of the controller or solver."""
        self.set(key, value)
        self._link.changed({key: value})

    def request_reset(self) -> None:
        """Restart the simulation; requires a run without log."""
        self.reset()
        self._push, self._tension, self._doubted = None, None, False
        self._shown = -math.inf, -math.inf
        self._link.changed(self.scenario.options().numbers())
        self._begin_clock()


REQUESTS: dict[str, Callable[..., None]] = {
    name.removeprefix("request_"): method for name, method in vars(Driven).items() if name.startswith("request_")
}


def _within(name: str, value: float, bounds: tuple[float, float]) -> float:
    least, most = bounds
    if not least <= value <= most:
        raise CdprError(f"{name}: expected a number from {least:g} to {most:g}, got {shown(value)}".lstrip(": "))
    return float(value)


def drive(
    scenario: Scenario,
    link: Link,
    *,
    out: RunFolder | str | None = None,
    speed: float = 1.0,
    rate: float = 60.0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Run:
    """Simulate a scenario with a live link, and return the run.

    Args:
        scenario: loaded scenario.
        link: live link.
        out: folder of the log, as in `cdpr.simulate`; only runs without it can be reset.
        speed: maximum speed as a multiple of the wall clock.
        rate: rate of shown samples, Hz of simulated time.
        progress: called with the number of samples and their total; may raise Interrupted.

    Raises:
        CdprError: as `cdpr.simulate` does.
    """
    return Driven(scenario, out, link, speed, rate).drive(progress)
