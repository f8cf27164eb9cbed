"""The loop of a live simulation: slice by slice, paced by the wall clock, with what is asked for done between two."""

from __future__ import annotations

import math
import queue
from collections.abc import Callable, Mapping
from contextlib import suppress
from time import monotonic
from typing import Any, Protocol

from cdpr import tolerances
from cdpr.errors import CdprError
from cdpr.live import RATES, SPEEDS
from cdpr.live.requests import Request, Requests
from cdpr.log.run import Header, Run
from cdpr.log.run_folder import RunFolder
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.problems import shown
from cdpr.scenario import Scenario
from cdpr.scenario.events.loads import Wrench
from cdpr.simulation.simulation import Simulation

WAITS = 0.2  # s, at most, between two calls of `progress` while it waits for the clock, or stands still
LOOKS = 60.0  # Hz of simulated time, at least, at which is looked at what was asked for
BUSY = 0.001  # s, at most, for what was asked for while a slice is due: the rest waits for one after it,
SHARE = 0.05  # so long that this share of the time, at most, goes to such requests
MOVE = 2.0  # s, of a move to a target that says no other


class Link(Protocol):
    """What shows a simulation to others, and hears them.

    Attributes:
        requests: what was asked for, also before the simulation begins, and is not done yet.
    """

    requests: Requests

    def begin(self, header: Header) -> None:
        """Take what is shown."""
        ...

    def show(self, row: Array, sample: int) -> None:
        """Take the newest sample, a copy; it is sent elsewhere."""
        ...

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Take parameters that have other values from now on."""
        ...

    def refused(self, text: str) -> None:
        """Tell who asked for something that cannot be."""
        ...

    def warned(self, text: str) -> None:
        """Tell who asked for something that is done, but seldom meant."""
        ...


class Driven(Simulation):
    """A simulation that goes on slice by slice, and does what is asked for."""

    def __init__(self, scenario: Scenario, out: RunFolder | str | None, link: Link, speed: float, rate: float) -> None:
        self._speed = _within("speed", speed, SPEEDS)
        self._period = 1.0 / _within("rate", rate, RATES)
        super().__init__(scenario, out=out)
        self.paused = False
        self._link = link
        # A whole number of slices is a period.
        self._slice = max(self._period / math.ceil(LOOKS * self._period), scenario.simulation.control_step)
        self._push: Wrench | None = None
        self._doubted = False  # whether the last target was
        self._tension: list[float] | None = None
        self._begin_clock()
        self._heeds = -math.inf  # by the clock: from when on it may be late for what was asked for
        self._shown = -math.inf, -math.inf  # when: by the clock, and of simulated time

    def drive(self, progress: Callable[[int, int], None]) -> Run:
        """Go on to the end; `progress` is called after each slice, and may raise Interrupted."""
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
        """Go on to a time; with tensions that are given, in place of the solver's."""
        if self._tension is None:
            self.until(time)
            return
        steps = round((time - self.time) / self.scenario.simulation.control_step)
        self.step(max(1, steps), tension=self._tension)

    def _showing(self, moving: bool) -> bool:
        """Whether the newest sample is to be shown now.

        In real time each period of simulated time, of a run that is faster each period of the clock, and of one that
        stands still now and then, for who comes meanwhile.
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
        """Count from now on; the next slice is due in so long (s)."""
        self._from = monotonic() + ahead, self.time

    @property
    def _ahead(self) -> float:
        """How long (s) until the next slice is due."""
        begun, time = self._from
        return math.inf if self.paused else (self.time - time) / self._speed - (monotonic() - begun)

    def _serve(self) -> bool:
        """Do what is asked for until the next slice is due, or for a while; return whether it is due."""
        requests, until = self._link.requests, monotonic() + WAITS
        try:
            while not self.done and (wait := min(self._ahead, until - monotonic())) > 0.0:
                self._answer(requests.get(wait))
        except queue.Empty:
            pass
        self._heed()
        if self._ahead < -1.0:  # it is slower than the clock: do not catch up in a rush later
            self._begin_clock()
        return self._ahead <= 0.0

    def _heed(self) -> None:
        """Do what is asked for although the slice is due; whoever asks without end does not hold it up."""
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
            if self._attempt.run is not None:  # it is no refusal: the run has ended
                raise
            what = request.values.get("key", request.what)
            self._link.refused(f"{what}: {error}" if what != request.answer.partition(":")[0] else request.answer)
        finally:
            request.done.set()

    def ask_pause(self, paused: bool = True) -> None:
        """Stand still, or go on."""
        if self.paused and not paused:
            self._begin_clock()
        self.paused = paused
        self._link.changed({"paused": paused})

    def ask_step(self, steps: int = 1) -> None:
        """Take some control steps, and stand still."""
        self.ask_pause()
        self.step(steps) if self._tension is None else self.step(steps, tension=self._tension)
        self._show()

    def ask_speed(self, speed: float) -> None:
        """Go so many times as fast as the wall clock."""
        speed = _within("", speed, SPEEDS)
        if not self.paused:
            self._begin_clock(max(self._ahead, 0.0) * self._speed / speed)
        self._speed = speed
        self._link.changed({"speed": speed})

    def ask_target(self, position: list[float], orientation: list[float], duration: float = MOVE) -> None:
        """Let the desired motion go to another pose of the origin, quaternion w, x, y, z; warn once."""
        self.target(position, orientation, duration=duration)
        doubts = self.scenario.doubts(self.events)
        if doubts and not self._doubted:
            self._link.warned(f"target: {'; '.join(doubts)}")
        self._doubted = bool(doubts)

    def ask_wrench(self, force: list[float], moment: list[float]) -> None:
        """Let this wrench act from now on, in place of the one before; none at all ends that."""
        if self._push is not None and (list(self._push.force), list(self._push.moment)) == (force, moment):
            return
        made = self.push(force, moment) if any(force + moment) else None
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
        checked(tension, (self.scenario.robot.m,), "tension", finite=True)  # refused at once where it makes no sense
        self._tension = tension

    def ask_stop(self) -> None:
        """Stop the robot as in an emergency."""
        self.stop()

    def ask_set(self, key: str, value: Any) -> None:
        """Give an option of controller or solver another value."""
        self.set(key, value)
        self._link.changed({key: value})

    def ask_reset(self) -> None:
        """Begin anew, where nothing is logged."""
        self.reset()
        self._push, self._tension, self._doubted = None, None, False
        self._shown = -math.inf, -math.inf
        self._link.changed(self.scenario.options().numbers())
        self._begin_clock()


REQUESTS: dict[str, Callable[..., None]] = {
    name.removeprefix("ask_"): method for name, method in vars(Driven).items() if name.startswith("ask_")
}


def _within(name: str, value: float, bounds: tuple[float, float]) -> float:
    least, most = bounds
    if not least <= value <= most:
        raise CdprError(f"{name}: a number from {least:g} to {most:g} is expected, got {shown(value)}".lstrip(": "))
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
