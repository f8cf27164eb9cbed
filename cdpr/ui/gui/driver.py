"""Thread that owns the simulation of the window: its driver, and the reports of its events.

No other thread accesses the simulation. Requests arrive in the queue of the driver, output goes to the broadcast, and
this thread never waits for a window. Failed runs, invalid scenarios and exceptions of plugins become a status with a
message; further requests are executed normally.
"""

from __future__ import annotations

import gc
import traceback
from collections.abc import Callable, Mapping
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING, Any, Literal

from cdpr.base.errors import CdprError, PlantEnded, one_line
from cdpr.base.redirect_output import redirect_output
from cdpr.cables import bends
from cdpr.simulation.clock import next_portion
from cdpr.simulation.driver import Driver
from cdpr.simulation.requests import Level, Reply, Request, unknown
from cdpr.simulation.robot_requests import NOT_SIMULATED
from cdpr.ui.gui.broadcast import Broadcast

if TYPE_CHECKING:
    from cdpr.scenario import Scenario
    from cdpr.ui.gui.session import SimulationSession

FRAME = 1.0 / 60.0  # s between two frames: the refresh rate of screens
IDLE = 0.5  # s after which an unchanged frame is sent again
SAMPLES, STATUS, IMAGES = 0.1, 0.2, 0.5  # s between two messages of these kinds during a run
PORTION_TIME = 1.0 / 30.0  # s of computation between two checks for requests
FIRST_PORTION, MAX_PORTION = 32, 16384  # steps between two checks: at the start, and at most
PATIENCE = 2.0  # s that `close` waits for the current step

# Status without a simulation, with the keys of `SimulationSession.about`.
NOTHING: dict[str, Any] = {
    **{"t": 0.0, "duration": 0.0, "status": "", "backend": "", "solver": "", "controller": ""},
    **{"events": [], "pushes": [], "cables": [], "winches": [], "sensors": [], "limits": None, "changeable": []},
}

Phase = Literal["building", "ready", "running", "paused", "done", "ended", "failed"]


class WindowDriver(Driver):
    """Owner of the simulation thread.

    Args:
        broadcast: receives all output.
        log: receives text that only the terminal shows, such as tracebacks of internal errors.
    """

    def __init__(self, broadcast: Broadcast, log: Callable[[str], None]) -> None:
        super().__init__(most=FIRST_PORTION)
        self._broadcast, self._log = broadcast, log
        self._session: SimulationSession | None = None
        self._scenario: Scenario | None = None
        self._phase: Phase = "building"
        self.paused = True
        self._text, self._fault = "", ""
        self._due = dict.fromkeys(("frame", "samples", "status", "images"), 0.0)
        self._writing: list[Thread] = []  # threads that write files and report later
        self._closed = False
        self._thread = Thread(target=self._loop, name="cdpr simulation", daemon=True)
        self._thread.start()

    def load(self, scenario: Scenario, reply: Reply | None = None) -> None:
        """Start another scenario."""
        self.requests.put(Request("load", reply=reply, action=partial(self._begin, scenario)))

    def command(self, do: str, arguments: Mapping[str, Any], reply: Reply) -> None:
        """Queue a command, executed between two steps; `reply` receives its messages."""
        try:
            self.requests.put(Request(do, dict(arguments), reply), replaceable=False)
        except CdprError as full:
            reply("error", str(full))

    def nothing(self) -> None:
        """Queue the status that no scenario can be simulated."""
        self.requests.put(Request("load", action=self._none))

    def close(self) -> None:
        """End the simulation and release its resources; running file operations are completed."""
        self.requests.put(Request("close", action=self._leave))
        self._thread.join(PATIENCE)
        for thread in self._writing:
            thread.join()

    def _leave(self) -> None:
        self._closed = True

    def _loop(self) -> None:
        with redirect_output():
            while not self._closed:
                self.serve()
                if not self._closed:
                    self._guarded(self._turn, self._to_all)
            self._guarded(self._end, self._to_all)
            self.requests.close("the window is closed")

    @property
    def accepting(self) -> bool:
        """True until it is closed; the window can restart runs that have ended."""
        return not self._closed

    @property
    def deadline(self) -> float:
        """Time of the next frame; runs without a limit of speed do not wait."""
        unpaced = self._remaining or (not self.paused and self.pacing.speed is None)
        return 0.0 if unpaced else self._due["frame"]

    def answer(self, request: Request) -> None:
        """Execute a request and report whatever it raises."""
        self._guarded(partial(super().answer, request), request.reply or self._to_all)

    def report(self, request: Request, level: Level, text: str) -> None:
        """Report to the window of the request, or to all."""
        (request.reply or self._to_all)(level, text)

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

    def _end(self) -> None:
        if self._session is not None:
            session, self._session = self._session, None
            self.attach(None)
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
        self.attach(self._session.simulation)
        self.most = FIRST_PORTION
        self._go_to("ready", "")
        if bends(scenario.robot):
            self._to_all("info", "Until the run starts, cables that sag are drawn as straight lines.")
        self._publish(everything=True)

    def perform(self, request: Request) -> object:
        """Execute a request, and publish the effects of a command; return its message."""
        answer = super().perform(request)
        if request.action is not None:
            return answer
        if self._session is not None:
            self._session.redraw()
        if callable(answer):
            reply = request.reply or self._to_all
            thread = Thread(target=lambda: self._guarded(lambda: reply("info", answer()), reply), name="files")
            thread.start()
            self._writing = [*filter(Thread.is_alive, self._writing), thread]
        self._publish(everything=True)
        return answer

    def handler(self, what: str) -> Callable[..., object]:
        """Return the function that executes a command of a window."""
        if what in ("save_session", "save_run"):
            if self._session is None:
                raise CdprError(NOT_SIMULATED)
            return getattr(self._session, what)  # type: ignore[no-any-return]
        if what in ("wrench", "tension", "winch_command"):  # no window sends streams
            raise unknown(what)
        return super().handler(what)

    def request_run(self) -> None:
        """Start or resume."""
        self.check_unfinished()
        self._go_to("running", "")

    def request_pause(self, paused: bool = True) -> None:
        """Pause or resume."""
        if not paused:
            self.request_run()
        elif self._phase == "running":
            self._go_to("paused", "")

    def request_reset(self) -> None:
        """Build the simulation again, also after a failure; it is then ready to run."""
        if self._scenario is None:
            raise CdprError("no scenario is applied yet")
        self._begin(self._scenario)

    def steps_done(self) -> None:
        """Publish the state after requested steps."""
        self._publish(everything=True)

    def request_step(self, n: int = 1) -> None:
        """Simulate some control steps and pause."""
        super().request_step(n)
        if self._phase == "ready":
            self._go_to("paused", "")

    def _turn(self) -> None:
        """Simulate up to the current time of the clock, and publish what is due."""
        began = self.clock.now()
        if self.advance() == self.most:
            self.most = next_portion(self.most, self.clock.now() - began, PORTION_TIME, MAX_PORTION)
        self._publish()

    def step(self, n: int) -> None:
        """Simulate n steps and set the phase if the run ends."""
        assert self._session is not None
        try:
            self._session.step(n, super().step)
        except CdprError as error:
            self._go_to("ended" if isinstance(error, PlantEnded) else "failed", str(error))
        else:
            if self.simulation.done:
                self._go_to("done", "")
        if self.simulation.done:
            self._publish(everything=True)

    def _go_to(self, phase: Phase, text: str) -> None:
        super().request_pause(phase != "running")
        self._phase, self._text = phase, text
        self._due["status"] = 0.0
        if phase == "building":
            self._status()

    def _publish(self, *, everything: bool = False) -> None:
        """Publish what is due: frames at screen rate, other messages less often."""
        running, now = self._phase == "running", self.clock.now()
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
                if everything or now >= self._due["images"]:
                    self._due["images"] = now + IMAGES
                    self._session.show_images()
        finally:
            if everything or self._due["status"] == 0.0 or (running and now >= self._due["status"]):
                self._status()

    def _status(self) -> None:
        self._due["status"] = self.clock.now() + STATUS
        about = NOTHING if self._session is None else self._session.about(self.acting())
        rtf = self.pacing.factor(self.simulation.time) if self._phase == "running" else None
        pace = {"phase": self._phase, "speed": self.pacing.speed, "rtf": rtf, "text": self._text}
        pace["manual"] = self._session is not None and self.manual.active
        self._broadcast.put({"kind": "status", **about, **pace})
