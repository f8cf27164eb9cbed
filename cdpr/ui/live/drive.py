"""Live simulation: a driver that shows samples to a link and executes its requests."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.scenario import Scenario
from cdpr.scenario.events import first_sample
from cdpr.simulation.clock import checked_speed
from cdpr.simulation.driver import WAITS, Driver
from cdpr.simulation.needs import require
from cdpr.simulation.requests import Level, Request
from cdpr.simulation.simulation import Simulation
from cdpr.ui.live import RATES
from cdpr.ui.live.sender import Sender

Out = RunFolder | str | None
LOOKS = 60.0  # Hz of simulated time, lowest rate at which requests are processed


class LiveDriver(Driver):
    """Driver of a simulation with a live link; arguments as for `drive`."""

    def __init__(
        self, scenario: Scenario, out: RunFolder | str | None, link: Sender, speed: float, rate: float
    ) -> None:
        checked_speed(speed)
        least, most = RATES
        if not least <= rate <= most:
            raise CdprError(f"rate: expected a number from {least:g} to {most:g}, got {shown(rate)}")
        self._link, self._period = link, 1.0 / rate
        self._shown = -math.inf, -math.inf  # clock time and simulated time of the last shown sample
        part = self._period / math.ceil(LOOKS * self._period)  # a whole number of slices per period
        steps = max(1, first_sample(part, scenario.simulation.control_step))
        super().__init__(Simulation(scenario, out=out), link.requests, speed=speed, slice_steps=steps, most=steps)

    def begin(self) -> None:
        """Start the link, too."""
        self._link.begin(self.simulation.header)
        self.changed({"paused": self.paused, "speed": self.pacing.speed})
        super().begin()

    def after_turn(self, moved: bool) -> None:
        """Show the newest sample, if it is due.

        Samples are shown once per period of simulated time at up to real time, once per period of the clock in faster
        runs, occasionally while paused, for new clients, and at the end.
        """
        now, (clock, time) = self.clock.now(), self._shown
        if moved:
            least = self._period * (1.0 - tolerances.TIME)
            due = (self.simulation.time - time if (self.pacing.speed or 2.0) <= 1.0 else now - clock) >= least
        else:
            due = now - clock >= WAITS
        if due or self.simulation.done:
            self._show()

    def _show(self) -> None:
        simulation = self.simulation
        if simulation.samples:
            self._link.show(simulation.row, simulation.samples - 1, simulation.header)
            self._shown = self.clock.now(), simulation.time

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Report changed parameters to the link."""
        self._link.changed(parameters)

    def report(self, request: Request, level: Level, text: str) -> None:
        """Report refusals and warnings to all clients of the link."""
        what = request.values.get("key", request.what)
        if level == "error":
            self._link.refused(f"{what}: {text}" if what != text.partition(":")[0] else text)
        elif level == "warning":
            self._link.warned(text)

    def steps_done(self) -> None:
        """Show the newest sample."""
        self._show()

    def request_reset(self) -> None:
        """Show the first samples, too."""
        super().request_reset()
        self._shown = -math.inf, -math.inf


def drive(
    scenario: Scenario,
    link: Sender,
    *,
    out: Out = None,
    speed: float = 1.0,
    rate: float = 60.0,
    progress: Callable[[int, int], None] | None = None,
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
    require(scenario, "live")
    return LiveDriver(scenario, out, link, speed, rate).run(progress)
