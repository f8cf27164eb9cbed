"""Thread that owns the simulation: it follows the clock, executes commands and reports events.

No other thread accesses the simulation. Commands arrive in a queue, output goes to the broadcast, and this thread never
waits for a window. Failed runs, invalid scenarios and exceptions of plugins become a status with a message; further
commands are executed normally.
"""

from __future__ import annotations

import gc
import traceback
from collections.abc import Callable, Mapping
from queue import Empty, SimpleQueue
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING, Any, Literal

from cdpr.base.errors import CdprError, PlantEnded, one_line
from cdpr.base.redirect_output import redirect_output
from cdpr.ui.gui.arguments import call
from cdpr.ui.gui.broadcast import Broadcast

if TYPE_CHECKING:
    from cdpr.scenario import Scenario
    from cdpr.ui.gui.session import SimulationSession

FRAME = 1.0 / 60.0  # s between two frames: the refresh rate of screens
IDLE = 0.5  # s after which an unchanged frame is sent again
SAMPLES, STATUS = 0.1, 0.2  # s between two messages of these kinds during a run
BUSY = 1.0 / 30.0  # s of computation between two checks for commands
LATE = 0.5  # s, or one step, of delay after which the simulation no longer tries to catch up
SLOWEST, FASTEST = 0.001, 1000.0  # relative to the clock
MOST_STEPS = 10_000  # per command
MOST_JOBS = 200  # pending commands
PATIENCE = 2.0  # s that `close` waits for the current step

# Status without a simulation, with the keys of `SimulationSession.about`.
NOTHING: dict[str, Any] = {
    **{"t": 0.0, "duration": 0.0, "status": "", "backend": "", "solver": "", "controller": ""},
    **{"events": [], "pushes": [], "cables": [], "limits": None, "changeable": []},
}

Level = Literal["error", "warning", "info"]
Reply = Callable[[Level, str], None]
Phase = Literal["building", "ready", "running", "paused", "done", "ended", "failed"]


class Driver:
    """Owner of the simulation thread.

    Args:
        broadcast: receives all output.
        log: receives text that only the terminal shows, such as tracebacks of internal errors.
    """

    def __init__(self, broadcast: Broadcast, log: Callable[[str], None]) -> None:
        self._broadcast, self._log = broadcast, log
        self._jobs: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._session: SimulationSession | None = None
        self._scenario: Scenario | None = None
        self._phase: Phase = "building"
        self._text, self._fault = "", ""
        self._speed: float | None = 1.0
        self._clock = Clock()
        self._due = dict.fromkeys(("frame", "samples", "status"), 0.0)
        self._writing: list[Thread] = []  # threads that write files and report later
        self._thread = Thread(target=self._loop, name="cdpr simulation", daemon=True)
        self._thread.start()

    def load(self, scenario: Scenario, reply: Reply | None = None) -> None:
        """Start another scenario."""
        self._jobs.put(lambda: self._guarded(lambda: self._begin(scenario), reply or self._to_all))

    def command(self, do: str, arguments: Mapping[str, Any], reply: Reply) -> None:
        """Queue a command, executed between two steps; `reply` receives its messages."""
        if self._jobs.qsize() > MOST_JOBS:
            reply("error", f"{do}: rejected: {MOST_JOBS} requests are pending")
            return
        self._jobs.put(lambda: self._guarded(lambda: self._do(do, arguments, reply), reply))

    def nothing(self) -> None:
        """Queue the status that no scenario can be simulated."""
        self._jobs.put(lambda: self._guarded(self._none, self._to_all))

    def close(self) -> None:
        """End the simulation and release its resources; running file operations are completed."""
        self._jobs.put(None)
        self._thread.join(PATIENCE)
        for thread in self._writing:
            thread.join()

    def _loop(self) -> None:
        with redirect_output():
            while True:
                try:
                    job = self._jobs.get(timeout=self._wait()) if self._wait() else self._jobs.get_nowait()
                    while True:
                        if job is None:
                            return self._finish()
                        job()
                        job = self._jobs.get_nowait()
                except Empty:
                    pass
                self._guarded(self._advance, self._to_all)

    def _wait(self) -> float:
        """Return the time until the next action, s."""
        if self._phase == "running" and self._speed is None:
            return 0.0
        return max(0.0, self._due["frame"] - monotonic())

    def _guarded(self, work: Callable[[], None], reply: Reply) -> None:
        """Do some work and report whatever it raises."""
        try:
            work()
        except CdprError as error:
            reply("error", str(error))
        except BaseException as error:  # even SystemExit: without this thread windows would hang
            trace, before = traceback.format_exc(), self._fault
            self._fault = trace
            if trace != before or reply != self._to_all:  # an error that repeats at each frame is reported once
                self._log(trace)
                reply("error", f"internal error: {one_line(error)}; the terminal has more")
            if self._phase == "running":
                self._go_to("failed", f"internal error: {one_line(error)}")

    def _to_all(self, level: Level, text: str) -> None:
        self._broadcast.put({"kind": "message", "level": level, "text": text})

    def _none(self) -> None:
        self._scenario = None
        self._end()
        self._go_to("failed", "not simulated: correct the errors in the form")

    def _finish(self) -> None:
        self._guarded(self._end, self._to_all)

    def _end(self) -> None:
        if self._session is not None:
            session, self._session = self._session, None
            session.close()
            del session
            gc.collect()  # a simulation has reference cycles with few but large objects, which Python would free late

    def _begin(self, scenario: Scenario) -> None:
        """Build a new simulation; if that fails, report it as a status and keep the last scene."""
        from cdpr.ui.gui.session import SimulationSession

        self._scenario = scenario
        self._go_to("building", "")
        self._guarded(self._end, self._to_all)
        try:
            self._session = SimulationSession(scenario, self._broadcast)
        except BaseException as error:
            self._go_to("failed", str(error) if isinstance(error, CdprError) else f"internal error: {one_line(error)}")
            raise
        self._go_to("ready", "")
        self._publish(monotonic(), everything=True)

    def _do(self, do: str, arguments: Mapping[str, Any], reply: Reply) -> None:
        own: dict[str, Callable[..., None]] = {
            "run": self._run,
            "pause": self._pause,
            "reset": self._reset,
            "step": self._step,
            "speed": self._pace,
        }
        if do in own:
            call(do, own[do], arguments)
        else:
            answer = self._current.do(do, arguments)
            if callable(answer):
                thread = Thread(target=lambda: self._guarded(lambda: reply("info", answer()), reply), name="files")
                thread.start()
                self._writing = [*filter(Thread.is_alive, self._writing), thread]
            elif answer:
                from cdpr.ui.gui.session import CommandWarning

                reply("warning" if isinstance(answer, CommandWarning) else "info", answer)
        self._publish(monotonic(), everything=True)

    @property
    def _current(self) -> SimulationSession:
        if self._session is None:
            raise CdprError("not simulated: correct the errors and apply, or reset")
        return self._session

    @property
    def _unfinished(self) -> SimulationSession:
        if self._current.over:
            raise CdprError("the run is over: reset it to run it again")
        return self._current

    def _run(self) -> None:
        session = self._unfinished
        self._clock.start(session.time, self._speed)
        self._go_to("running", "")

    def _pause(self) -> None:
        if self._phase == "running":
            self._go_to("paused", "")

    def _reset(self) -> None:
        if self._scenario is None:
            raise CdprError("no scenario is applied yet")
        self._begin(self._scenario)

    def _step(self, n: int = 1) -> None:
        if type(n) is not int or not 1 <= n <= MOST_STEPS:
            raise CdprError(f"step: expected a whole number from 1 to {MOST_STEPS}, got {n!r}")
        session = self._unfinished
        self._pause()
        self._simulate(session, n)
        if self._phase == "ready":
            self._go_to("paused", "")

    def _pace(self, value: float | None = None) -> None:
        if value is not None and not (isinstance(value, int | float) and SLOWEST <= value <= FASTEST):
            raise CdprError(f"speed: expected a number from {SLOWEST:g} to {FASTEST:g}, or null, got {value!r}")
        self._speed = value
        if self._session is not None:
            self._clock.start(self._session.time, value)

    def _advance(self) -> None:
        """Simulate up to the current time of the clock, and publish what is due."""
        if self._phase == "running":
            session = self._current
            n = self._clock.steps(session.time, session.period)
            if n:
                self._simulate(session, n)
        self._publish(monotonic())

    def _simulate(self, session: SimulationSession, n: int) -> None:
        """Simulate n steps and set the phase if the run ends."""
        began = monotonic()
        try:
            session.step(n)
        except CdprError as error:
            self._go_to("ended" if isinstance(error, PlantEnded) else "failed", str(error))
        else:
            self._clock.took(n, monotonic() - began)
            if session.over:
                self._go_to("done", "")
        if session.over:
            self._publish(monotonic(), everything=True)

    def _go_to(self, phase: Phase, text: str) -> None:
        self._phase, self._text = phase, text
        self._due["status"] = 0.0
        if phase == "building":
            self._status(monotonic())

    def _publish(self, now: float, *, everything: bool = False) -> None:
        """Publish what is due: frames at screen rate, other messages less often."""
        running = self._phase == "running"
        if now < self._due["frame"] and self._due["status"] and not everything:
            return
        # A fixed beat keeps the frame rate independent of computation time; a missed beat starts a new one.
        beat = self._due["frame"] if 0.0 <= now - self._due["frame"] < FRAME else now
        self._due["frame"] = beat + FRAME if running else now + IDLE
        try:
            if self._session is not None:
                self._session.show_frame()
                if everything or now >= self._due["samples"]:
                    self._due["samples"] = now + SAMPLES
                    self._session.show_curves()
        finally:
            if everything or self._due["status"] == 0.0 or (running and now >= self._due["status"]):
                self._status(now)

    def _status(self, now: float) -> None:
        self._due["status"] = now + STATUS
        about = NOTHING if self._session is None else self._session.about()
        rtf = self._clock.factor(now, self._session.time) if self._session and self._phase == "running" else None
        pace = {"phase": self._phase, "speed": self._speed, "rtf": rtf, "text": self._text}
        self._broadcast.put({"kind": "status", **about, **pace})


class Clock:
    """Number of steps that are due: by the wall clock, or as many as fit between two checks of the queue."""

    def __init__(self) -> None:
        self._rate = 1000.0  # measured steps per second of computation
        self.start(0.0, 1.0)

    def start(self, time: float, speed: float | None) -> None:
        """Start at a simulation time (s); `speed` is simulated time over wall time, None for unlimited."""
        self._speed = speed
        self._wall, self._time = monotonic(), time
        self._then, self._factor = (self._wall, time), None if speed is None else speed

    def steps(self, time: float, period: float) -> int:
        """Return the number of steps of `period` (s) that are due."""
        most = max(1, int(self._rate * BUSY))
        if self._speed is None:
            return most
        wall = monotonic()
        behind = self._time + self._speed * (wall - self._wall) - time
        late = max(self._speed * LATE, period)  # largest delay to catch up with: one step, or LATE seconds of the clock
        if behind > late:  # too slow: continue at full speed without catching up
            self._wall, self._time = wall, time + late
        return min(most, max(0, int(behind / period)))

    def took(self, steps: int, seconds: float) -> None:
        """Update the measured rate."""
        if steps and seconds > 0.0:
            self._rate += 0.2 * (steps / seconds - self._rate)

    def factor(self, wall: float, time: float) -> float | None:
        """Return the real-time factor of about the last second."""
        then, before = self._then
        if wall - then >= 1.0:
            self._factor, self._then = (time - before) / (wall - then), (wall, time)
        return None if self._factor is None else round(self._factor, 4)
