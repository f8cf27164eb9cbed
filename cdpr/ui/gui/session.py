"""A simulation and its display; only the simulation thread accesses it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.errors import CdprError, OutputError
from cdpr.cables import TENSION, commands_of, takes_lengths
from cdpr.log.event import Event
from cdpr.log.interference import cables_in_contact
from cdpr.log.rows import IN_MEMORY
from cdpr.log.run import Run
from cdpr.log.run_folder import folder_name
from cdpr.log.save import save
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent, first_sample
from cdpr.scenario.events.faults import CableFault
from cdpr.scenario.events.limits import TensionLimits
from cdpr.scenario.events.loads import Wrench
from cdpr.scenario.events.payload import Payload
from cdpr.sensing.sensor import measuring
from cdpr.simulation import Simulation
from cdpr.simulation.events import MOST
from cdpr.simulation.needs import require
from cdpr.simulation.runner import SESSION_NAME
from cdpr.simulation.session import table_beside
from cdpr.tension.stage import MEANING
from cdpr.tension.status import Status
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.drawing import Drawing, in_json
from cdpr.ui.gui.editor.fields import shown
from cdpr.ui.gui.editor.files import named
from cdpr.ui.gui.scratch import scratch

if TYPE_CHECKING:
    from cdpr.ui.gui.images import LatestImages

Later = Callable[[], str]


BLOCK = 1024  # samples per step call, fewer than a simulation keeps in memory
FATES = ("broken", "jammed")


class SimulationSession:
    """Simulation whose output goes to the broadcast.

    Raises:
        CdprError: if it cannot be built.
    """

    def __init__(self, scenario: Scenario, broadcast: Broadcast) -> None:
        require(scenario, "live")
        self.scenario = scenario
        self._broadcast, self._drawing = broadcast, Drawing(scenario)
        self._kept = ExitStack()
        header = self._drawing.header
        size = 8 * header.layout.width * (scenario.simulation.steps // header.log_every + 1)
        out = None  # runs that would fill the memory go to a temporary folder
        if size > IN_MEMORY:
            out = self._kept.enter_context(scratch()).path
        with self._kept:
            self._sim = Simulation(scenario, out=out)
            self._kept = self._kept.pop_all()
        self._processed = 0  # samples processed into curves and spans
        self._status = Status.OK
        self._spans: list[tuple[Status, int]] = []  # start and status of intervals without a valid solution
        self._run: Run | None = None
        self._saved: set[Path] = set()  # saved by this simulation
        sim = self._sim
        self._drawing.change(sim.events)
        self._frame = self._drawing.still(sim.state, sim.desired)
        with broadcast.changed:
            broadcast.curves.begin(self._drawing.columns, sim.steps + 1)
            broadcast.put(self._drawing.scene(sim.state, sim.desired))
            broadcast.put(self._frame)
        self._images: LatestImages | None = None
        if header.imaging:
            from cdpr.ui.gui.images import LatestImages  # few scenarios need this import

            self._images = LatestImages(header)
            self._kept.callback(self._images.close)
            broadcast.put(self._images.message)
        elif broadcast.latest("images"):
            broadcast.put({"kind": "images", "cameras": []})

    @property
    def simulation(self) -> Simulation:
        """The simulation."""
        return self._sim

    @property
    def period(self) -> float:
        """Control period, s."""
        return self.scenario.simulation.control_step

    def step(self, n: int, step: Callable[[int], None]) -> None:
        """Simulate n control steps, or those that remain, by `step`; exceptions that end the run early are raised."""
        try:
            while n > 0 and not self._sim.done:
                step(min(n, BLOCK))
                n -= BLOCK
                if self._sim.samples - self._processed > BLOCK:
                    self._process_rows()
        finally:
            if self._sim.done:
                self._process_rows()
                self._broadcast.curves.end()
                self._run = self._sim.run()

    def redraw(self) -> None:
        """Draw the present events from now on."""
        self._drawing.change(self._sim.events)
        if self._images is not None:
            self._images.amend(self._drawing.header)

    def show_frame(self) -> None:
        """Publish the frame of the last complete sample, if there is one."""
        last = self._sim.samples - 1
        if last >= 0 and self._frame["n"] != last:
            self._frame = self._drawing.frame(last, self._sim.row)
        self._broadcast.put(self._frame)

    def show_images(self) -> None:
        """Publish the images of the last complete sample, if cameras take one.

        Raises:
            CdprError: if no renderer works on this machine, once.
        """
        last = self._sim.samples - 1
        if self._images is not None and last >= 0 and self._images.take(last, self._sim.row):
            self._broadcast.put(self._images.message)

    def show_curves(self) -> None:
        """Publish the curves up to the current time."""
        self._process_rows()
        with self._broadcast.changed:
            self._broadcast.curves.show()
            self._broadcast.changed.notify_all()

    def about(self, pushes: Iterable[tuple[int, Wrench | Payload]]) -> dict[str, Any]:
        """Return the content of a status message on the simulation and the pushes and bodies that can be released."""
        scenario, events = self.scenario, self._happened()
        options = scenario.options()
        for event in events:
            list(event.check_options(options))
        values: dict[str, Any] = {role: model.model_dump(mode="json") for role, model in options.values.items()}
        keys = [(key, *key.split(".", 1)) for key in options.changeable()]
        fates = {str(event.cable): event.fate for event in events if isinstance(event, CableFault)}
        return {
            "t": round(self._sim.time, 9),
            "duration": scenario.simulation.steps * self.period,
            "status": self._status.name if self._run is None else self._run.status.upper(),
            "events": _latest([{"t": event.time, "text": event.text} for event in self._event_log(events)]),
            "pushes": [{"id": key, "text": _released(push)} for key, push in pushes],
            "cables": [
                {"name": cable.name, **{fate: fates.get(cable.name) == fate for fate in FATES}}
                for cable in scenario.robot.cables
            ],
            "winches": self._winches(),
            "sensors": [sensor.title for sensor in measuring(scenario.sections.sensors)],
            "limits": self._in_force(events),
            "backend": scenario.simulation.backend,
            "solver": scenario.solver.type,
            "controller": scenario.controller.type,
            "changeable": [{"key": key, "value": shown(values[role][name], "vector")} for key, role, name in keys],
        }

    def close(self) -> None:
        """End the simulation and remove temporary files."""
        with self._kept:
            self._sim.close()

    def _process_rows(self) -> None:
        """Process new samples into curves and spans."""
        rows = self._sim.rows(self._processed)
        if not len(rows):
            return
        self._broadcast.curves.add(self._drawing.curves(rows))
        status = Run(self._drawing.header, rows).solver_status
        for k in np.flatnonzero(np.diff(status, prepend=float(self._status))).tolist():
            if status[k] != Status.OK and len(self._spans) < MOST:
                self._spans.append((Status(int(status[k])), self._processed + k))
        self._status = Status(int(status[-1]))
        self._processed += len(rows)

    def _happened(self) -> list[ScenarioEvent]:
        """Return the events that act at the current sample or acted before, sorted by time."""
        period, samples = self.period, self._sim.samples
        events = sorted(self._sim.events, key=attrgetter("time"))
        return [event for event in events if first_sample(event.time, period) <= samples]

    def _event_log(self, events: list[ScenarioEvent]) -> Iterator[Event]:
        """Yield log entries of past events and solver failures; after the end, those of the run."""
        if self._run is not None:
            yield from self._run.events
            return
        entries = [one for event in events for one in event.event_log(self.period, self._sim.samples + 1, {})]
        entries += [Event(first * self.period, status.name.lower(), MEANING[status]) for status, first in self._spans]
        yield from sorted(entries, key=attrgetter("time"))

    def _in_force(self, events: list[ScenarioEvent]) -> dict[str, list[float | None]]:
        """Return the current tension limits, N, after these events."""
        header = self._drawing.header
        low, high = list(header.tension_min), list(header.tension_max)
        for event in events:
            if not isinstance(event, TensionLimits):
                continue
            for i, name in enumerate(header.cables):
                if event.cable in (None, name):
                    low[i] = low[i] if event.min is None else event.min
                    high[i] = high[i] if event.max is None else event.max
        return in_json(low, high)

    def _winches(self) -> list[dict[str, Any]]:
        """Return the winches that take lengths or rates, with their cables and present unwound lengths, m."""
        robot, sim = self.scenario.robot, self._sim
        takes = commands_of(robot)
        if not takes_lengths(robot) or not sim.samples:
            lengths: list[float | None] = [None] * robot.m
        else:
            lengths = sim.row[self._drawing.header.layout.columns["unstretched_length"]].round(6).tolist()
        every = zip(robot.cables, takes, lengths, strict=True)
        return [
            {"name": cable.name, "takes": each, "unwound": length} for cable, each, length in every if each != TENSION
        ]

    def save_session(self, out: str) -> str:
        """Save the session; overwrite only files that this simulation has saved."""
        path = Path(named(out))
        place = path.resolve()
        there = [each for each in (path, table_beside(path)) if os.path.lexists(each)]
        if there and place not in self._saved:
            raise OutputError(f"'{there[0]}' already exists and is not overwritten: choose another name")
        self._sim.save(path)
        self._saved.add(place)
        return f"the session is saved: cdpr run {out} repeats it"

    def save_run(self, out: str = "") -> Later:
        """Write the log, summary and scenario now, and the report, which takes longer, later."""
        if not self._sim.samples:
            raise CdprError("save_run: no sample is complete before the first step")
        run = save(self._sim.so_far(), folder_name(out) if out else None, scenario=self.scenario.yaml_in)
        assert run.folder is not None
        if self._sim._runner.session:
            self._sim.save(Path(run.folder) / SESSION_NAME)
        touch = cables_in_contact(self.scenario.robot, run, self.scenario.obstacles)
        return partial(_report, run, Path(run.folder), touch)


def _latest(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the latest events, and the number of earlier ones."""
    earlier = len(entries) - MOST
    return (
        entries if earlier <= 0 else [{"t": entries[0]["t"], "text": f"{earlier} earlier events"}, *entries[earlier:]]
    )


def _report(run: Run, folder: Path, touch: str | None) -> str:
    from cdpr.ui.report.pages.run import write_report

    write_report(run, folder / "report.html", touch=touch)
    return f"the run is saved in {folder}"


def _released(push: Wrench | Payload) -> str:
    """Return a push or an attached body as text."""
    if isinstance(push, Payload):
        return f"{push.mass:g} kg"
    parts = [(push.force, "N"), (push.moment, "N m")]
    return ", ".join(f"[{', '.join(f'{x:g}' for x in values)}] {unit}" for values, unit in parts if any(values))


__all__ = ["SimulationSession"]
