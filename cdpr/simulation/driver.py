"""Driver of a running simulation: clock, speed, and the requests of other threads.

Real-time runs, live links and the window are clients of it. A request is queued by any thread and executed between two
control steps by the thread of the simulation. Requests that act on the robot become events of the scenario at the
present time, so that the saved session repeats the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.blocks import BLOCK
from cdpr.log.run import Run
from cdpr.simulation.arguments import call
from cdpr.simulation.clock import Pacing, checked_speed
from cdpr.simulation.requests import URGENT, CommandWarning, Request, Requests, unknown
from cdpr.simulation.robot_requests import RobotRequests
from cdpr.simulation.simulation import Simulation

WAITS = 0.2  # s, longest time between two calls of `progress` while it waits or is paused
REQUEST_TIME = 0.001  # s, time limit for requests while a slice is due; further requests wait
SHARE = 0.05  # largest share of the time spent on such requests
MOST_STEPS = 10_000  # per request
INTERRUPTING = ("pause", "run", "reset", "load")  # requests that also end the remaining steps of a request, if next
INTERRUPTED = "step: interrupted, {} steps remain"
# Requests that are methods of the simulation.
FORWARDED = ("cut", "jam", "fail_sensor", "occlude_sensor", "bump_sensor")


class Driver(RobotRequests):
    """Simulation that follows a clock and executes requests between two control steps.

    Only one thread, that of the simulation, calls its methods. Others put requests into the queue.

    Args:
        simulation: simulation; may follow later, by `attach`.
        requests: queue, which may contain requests already.
        speed: simulated time over time of the clock; None for no limit.
        slice_steps: number of control steps that become due at once.
        most: largest number of control steps between two checks for requests.

    Attributes:
        requests, slice_steps, most: as above.
        clock: clock of the queue.
        pacing: simulated time that is due.
        paused: True if no time becomes due.
    """

    def __init__(
        self,
        simulation: Simulation | None = None,
        requests: Requests | None = None,
        *,
        speed: float | None = 1.0,
        slice_steps: int = 1,
        most: int = BLOCK,
    ) -> None:
        super().__init__()
        self.requests = Requests() if requests is None else requests
        self.clock = self.requests.clock
        self.pacing = Pacing(self.clock, checked_speed(speed))
        self.paused = False
        self.slice_steps, self.most = slice_steps, most
        self._late_from = -math.inf  # time of the clock from which late requests are processed
        self._remaining = 0  # steps of the request that is answered after them
        self._stepping: Request | None = None  # that request
        self.attach(simulation)

    def attach(self, simulation: Simulation | None) -> None:
        """Drive another simulation, or none."""
        self.end_steps()
        self.act_on(simulation)
        if simulation is not None:
            self.pacing.slice = self.slice_steps * simulation.scenario.simulation.control_step
            self.pacing.start(simulation.time)

    @property
    def accepting(self) -> bool:
        """True if requests are executed."""
        return not self.simulation.done

    @property
    def deadline(self) -> float:
        """Time of the clock at which something other than requests is due."""
        if self._remaining:
            return -math.inf
        return math.inf if self.paused else self.pacing.when(self.simulation.time)

    def run(self, progress: Callable[[int, int], None] | None = None) -> Run:
        """Simulate to the end, and return the run.

        Args:
            progress: called with the number of samples and their total after each slice, and while it waits; may raise
                Interrupted.

        Raises:
            CdprError: as `cdpr.simulate` does.
        """
        simulation = self.simulation
        try:
            with simulation._kept():
                self.begin()
                while not simulation.done:
                    if progress is not None:
                        progress(simulation.samples, simulation.steps + 1)
                    self.serve()
                    moved = not simulation.done and self.advance() > 0
                    if not moved:
                        simulation._pace.after(simulation.samples)
                    self.after_turn(moved)
            return simulation.run()
        finally:
            self.end_steps()
            self.requests.close("the run is over")

    def serve(self) -> None:
        """Execute requests until something else is due, but not for long."""
        until = self.clock.now() + WAITS
        while self.accepting and (wait := min(self.deadline, until) - self.clock.now()) > 0.0:
            request = self._next(wait)
            if request is not None:
                self.answer(request)
        # if a slice is due: endless requests must not block the simulation
        begun = now = self.clock.now()
        while self.accepting and (
            (begun >= self._late_from and now - begun <= REQUEST_TIME) or self.requests.pending(URGENT)
        ):
            request = self._next()
            if request is None:
                break
            self.answer(request)
            now = self.clock.now()
        self._late_from = max(self._late_from, now + min((now - begun) / SHARE, WAITS))

    def _next(self, timeout: float = 0.0) -> Request | None:
        """Return the next request; while requested steps remain, only if it or an urgent one ends them."""
        if self._remaining:
            if not self.requests.pending(URGENT, first=INTERRUPTING):
                return None
            self.end_steps()
        return self.requests.get(timeout)

    def advance(self) -> int:
        """Simulate what is due, or requested steps that remain, up to `most` control steps; return their number."""
        if self._remaining:
            n = min(self._remaining, self.most)
            self._step_portion(n)
            return n
        if self.paused:
            return 0
        due = self.pacing.slices(self.simulation.time)
        n = self.most if due is None else min(self.most, due * self.slice_steps)
        if n:
            self.step(n)
        return n

    def step(self, n: int) -> None:
        """Simulate n control steps, or those that remain, with the requested commands, if any."""
        self.manual.step(n)

    def _step_portion(self, n: int) -> None:
        """Simulate n of the requested steps; if they are the last, answer the request."""
        try:
            self.step(n)
        except BaseException as error:
            if self._stepping is not None:
                self._stepping.answer = str(error)
            self._remaining = 0
            raise
        else:
            self._remaining = 0 if self.simulation.done else self._remaining - n
        finally:
            if not self._remaining:
                self.steps_done()
                self.end_steps()

    def end_steps(self) -> None:
        """Drop the requested steps that remain, and answer their request."""
        request, self._stepping, remaining, self._remaining = self._stepping, None, self._remaining, 0
        if request is not None and remaining:
            request.refuse(INTERRUPTED.format(remaining))
        elif request is not None:
            request.done.set()

    def answer(self, request: Request) -> None:
        """Execute a request and report its result.

        Raises:
            CdprError: if the run has ended by it.
        """
        try:
            result = self.perform(request)
        except CdprError as error:
            request.answer = str(error)
            if self._simulation is not None and self._simulation._runner.run is not None:
                raise
            self.report(request, "error", request.answer)
        else:
            if isinstance(result, str):
                self.report(request, "warning" if isinstance(result, CommandWarning) else "info", result)
        finally:
            if self._remaining and self._stepping is None:
                self._stepping = request  # answered by `end_steps`
            else:
                request.done.set()

    def perform(self, request: Request) -> object:
        """Execute a request; return its message, if any.

        Raises:
            CdprError: if it is refused; then nothing has changed.
        """
        if request.action is not None:
            return request.action()
        return call(request.what, self.handler(request.what), request.values)

    def handler(self, what: str) -> Callable[..., object]:
        """Return the function that executes requests of this name.

        Raises:
            CdprError: if the name is unknown.
        """
        if what in FORWARDED:
            return getattr(self.simulation, what)  # type: ignore[no-any-return]
        method: Callable[..., object] | None = getattr(self, f"request_{what}", None)
        if method is None:
            raise unknown(what)
        return method

    def begin(self) -> None:
        """Start the clock; clients override it to prepare their output."""
        self.pacing.start(self.simulation.time)

    def after_turn(self, moved: bool) -> None:
        """Show the newest sample after each turn of `run`; `moved` is False while it waits or is paused."""

    def steps_done(self) -> None:
        """Show the newest sample after requested steps."""

    def check_unfinished(self) -> None:
        """Raise CdprError if no step is left."""
        if self.simulation.done:
            raise CdprError("the run is over: reset it to run it again")

    def request_pause(self, paused: bool = True) -> None:
        """Pause or resume."""
        if self.paused and not paused:
            self.pacing.start(self.simulation.time)
        self.paused = paused
        self.changed({"paused": paused})

    def request_step(self, n: int = 1) -> None:
        """Simulate some control steps and pause; only requests in `INTERRUPTING` and `URGENT` do not wait for them."""
        if type(n) is not int or not 1 <= n <= MOST_STEPS:
            raise CdprError(f"step: expected a whole number from 1 to {MOST_STEPS}, got {shown(n)}")
        self.check_unfinished()
        if self.requests.pending(URGENT):
            raise CdprError(INTERRUPTED.format(n))
        self.request_pause()
        self._remaining = n
        self._step_portion(min(n, self.most))

    def request_speed(self, value: float | None = None) -> None:
        """Set the speed as a multiple of the clock's; None for no limit."""
        speed = checked_speed(value)
        self.pacing.change(speed, 0.0 if self._simulation is None else self._simulation.time)
        self.changed({"speed": speed})

    def request_reset(self) -> None:
        """Restart the simulation; requires a run without log. It stays paused or continues, as before."""
        simulation = self.simulation
        simulation.reset()
        self.attach(simulation)
        self.changed(simulation.scenario.options().numbers())
