"""One simulation, and what is seen of it; the thread that makes it is the only one that touches it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from functools import partial
from itertools import count
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.errors import CdprError, OutputError
from cdpr.gui.arguments import call
from cdpr.gui.board import Board
from cdpr.gui.desk.fields import shown
from cdpr.gui.desk.files import named
from cdpr.gui.drawing import Drawing
from cdpr.gui.scratch import scratch
from cdpr.log.event import Event
from cdpr.log.rows import IN_MEMORY
from cdpr.log.run import Run
from cdpr.log.run_folder import folder_name
from cdpr.log.save import save
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent, first_sample
from cdpr.scenario.events.faults import CableFault
from cdpr.scenario.events.limits import TensionLimits
from cdpr.scenario.events.loads import Wrench
from cdpr.simulation import Simulation
from cdpr.simulation.attempt import SESSION_NAME
from cdpr.simulation.events import MOST
from cdpr.simulation.session import table_beside
from cdpr.tension.stage import MEANING
from cdpr.tension.status import Status

Later = Callable[[], str]


BLOCK = 1024  # samples that are taken before they are looked at: fewer than a simulation keeps at hand
FATES = ("broken", "jammed")
TARGET_SECONDS = 2.0  # that the way to a new target takes unless said


class Doubt(str):
    """What a window is warned of: it was done, and is seldom meant."""

    __slots__ = ()


class Stage:
    """A simulation from its beginning, and its picture on the board.

    Raises CdprError where it cannot be built.
    """

    def __init__(self, scenario: Scenario, board: Board) -> None:
        self.scenario = scenario
        self._board, self._drawing = board, Drawing(scenario)
        self._kept = ExitStack()
        header = self._drawing.header
        size = 8 * header.layout.width * (scenario.simulation.steps // header.log_every + 1)
        out = None  # what would fill the memory goes to a folder that is gone in the end
        if size > IN_MEMORY:
            out = self._kept.enter_context(scratch())
        with self._kept:
            self._sim = Simulation(scenario, out=out)
            self._kept = self._kept.pop_all()
        self._looked = 0  # samples that are in curves and spans
        self._status = Status.OK
        self._spans: list[tuple[Status, int]] = []  # where tensions were not found any more, and why
        self._pushes: dict[int, Wrench] = {}
        self._numbers = count(1)
        self._run: Run | None = None
        self._sessions: set[Path] = set()  # that were saved
        sim = self._sim
        self._drawing.change(sim.events)
        self._frame = self._drawing.still(sim.state, sim.desired)
        with board.changed:
            board.curves.begin(self._drawing.columns, sim.steps + 1)
            board.put(self._drawing.scene(sim.state, sim.desired))
            board.put(self._frame)

    @property
    def time(self) -> float:
        """Present time, s."""
        return self._sim.time

    @property
    def period(self) -> float:
        """Control period, s."""
        return self.scenario.simulation.control_step

    @property
    def over(self) -> bool:
        """Whether nothing is left to do."""
        return self._sim.done

    def step(self, n: int) -> None:
        """Take so many control steps, or as many as are left; raises what ends the run early."""
        try:
            while n > 0 and not self._sim.done:
                self._sim.step(min(n, BLOCK))
                n -= BLOCK
                if self._sim.samples - self._looked > BLOCK:
                    self._look()
        finally:
            if self._sim.done:
                self._look()
                self._board.curves.end()
                self._run = self._sim.run()

    def do(self, what: str, arguments: Mapping[str, Any]) -> str | Later:
        """Let something be done to the simulation now; return what there is to say of it. Raises CdprError.

        What is `Later` takes its time, touches the simulation no more, and returns what there is to say then.
        """
        sim = self._sim
        doing: dict[str, Callable[..., object]] = {
            "push": self._push,
            "release": self._release,
            "cut": sim.cut,
            "jam": sim.jam,
            "limits": self._limits,
            "stop": sim.stop,
            "target": self._target,
            "set": sim.set,
            "save_session": self._save_session,
            "save_run": self._save_run,
        }
        if what not in doing:
            raise CdprError(f"'{what[:40]}' is nothing that a window may ask for")
        said = call(what, doing[what], arguments)
        self._drawing.change(sim.events)
        return said if isinstance(said, str) or callable(said) else ""

    def show_frame(self) -> None:
        """Put the present frame on the board: of the last complete sample, unless none is."""
        last = self._sim.samples - 1
        if last >= 0 and self._frame["n"] != last:
            self._frame = self._drawing.frame(last, self._sim.row)
        self._board.put(self._frame)

    def show_curves(self) -> None:
        """Let windows have the curves up to here."""
        self._look()
        with self._board.changed:
            self._board.curves.show()
            self._board.changed.notify_all()

    def about(self) -> dict[str, Any]:
        """Return what a status says of the simulation."""
        scenario, events = self.scenario, self._happened()
        options = scenario.options()
        for event in events:
            list(event.check_options(options))
        values: dict[str, Any] = {role: model.model_dump(mode="json") for role, model in options.values.items()}
        keys = [(key, *key.split(".", 1)) for key in options.changeable()]
        fates = {str(event.cable): event.fate for event in events if isinstance(event, CableFault)}
        return {
            "t": round(self.time, 9),
            "duration": scenario.simulation.steps * self.period,
            "status": self._status.name if self._run is None else self._run.status.upper(),
            "events": _latest([{"t": event.time, "text": event.text} for event in self._told(events)]),
            "pushes": [{"id": key, "text": _wrench(push)} for key, push in self._acting()],
            "cables": [
                {"name": cable.name, **{fate: fates.get(cable.name) == fate for fate in FATES}}
                for cable in scenario.robot.cables
            ],
            "limits": self._in_force(events),
            "backend": scenario.simulation.backend,
            "solver": scenario.solver.type,
            "controller": scenario.controller.type,
            "changeable": [{"key": key, "value": shown(values[role][name], "vector")} for key, role, name in keys],
        }

    def close(self) -> None:
        """End the simulation, and leave nothing on the disk that nobody asked for."""
        with self._kept:
            self._sim.close()

    def _look(self) -> None:
        """Take what the simulation has made since the last look into curves and spans."""
        rows = self._sim.rows(self._looked)
        if not len(rows):
            return
        self._board.curves.add(self._drawing.curves(rows))
        status = Run(self._drawing.header, rows).solver_status
        for k in np.flatnonzero(np.diff(status, prepend=float(self._status))).tolist():
            if status[k] != Status.OK and len(self._spans) < MOST:
                self._spans.append((Status(int(status[k])), self._looked + k))
        self._status = Status(int(status[-1]))
        self._looked += len(rows)

    def _happened(self) -> list[ScenarioEvent]:
        """The events that act on the present sample, or did before, in the order of time."""
        period, samples = self.period, self._sim.samples
        events = sorted(self._sim.events, key=attrgetter("time"))
        return [event for event in events if first_sample(event.time, period) <= samples]

    def _told(self, events: list[ScenarioEvent]) -> Iterator[Event]:
        """Yield what there is to say of what has happened; after the end all that the run says."""
        if self._run is not None:
            yield from self._run.events
            return
        told = [one for event in events for one in event.tell(self.period, self._sim.samples + 1, {})]
        told += [Event(first * self.period, status.name.lower(), MEANING[status]) for status, first in self._spans]
        yield from sorted(told, key=attrgetter("time"))

    def _in_force(self, events: list[ScenarioEvent]) -> dict[str, list[float]]:
        """Return the limits of tension, N, that these events have left."""
        header = self._drawing.header
        low, high = list(header.tension_min), list(header.tension_max)
        for event in events:
            if not isinstance(event, TensionLimits):
                continue
            for i, name in enumerate(header.cables):
                if event.cable in (None, name):
                    low[i] = low[i] if event.min is None else event.min
                    high[i] = high[i] if event.max is None else event.max
        return {"tension_min": low, "tension_max": high}

    def _acting(self) -> Iterator[tuple[int, Wrench]]:
        """Yield the pushes that can be released."""
        for key, push in self._pushes.items():
            swing = push.swing(self.period)
            if swing is not None and swing.end > self._sim.samples and not self._sim.done:
                yield key, push

    def _push(self, force: Any = (0.0, 0.0, 0.0), moment: Any = (0.0, 0.0, 0.0), duration: float | None = None) -> None:
        self._pushes[next(self._numbers)] = self._sim.push(force, moment, duration=duration)

    def _release(self, id: int) -> None:
        push = next((push for key, push in self._acting() if key == id), None)
        if push is None:
            raise CdprError("release: that push has ended")
        self._sim.release(push)
        del self._pushes[id]

    def _limits(self, tension_min: float | None = None, tension_max: float | None = None) -> None:
        self._sim.limits(tension_min, tension_max)

    def _target(self, position: Any = None, rpy: Any = None, duration: float | None = None) -> str:
        attitude = None if rpy is None else {"rpy": rpy}
        self._sim.target(position, attitude, duration=TARGET_SECONDS if duration is None else duration)
        doubts = self.scenario.doubts(self._sim.events)
        return Doubt(f"target: {'; '.join(doubts)}" if doubts else "")

    def _save_session(self, out: str) -> str:
        """Write over nothing but what this simulation has saved before."""
        path = Path(named(out))
        place = path.resolve()
        there = [each for each in (path, table_beside(path)) if os.path.lexists(each)]
        if there and place not in self._sessions:
            raise OutputError(f"'{there[0]}' is there already: it is not written over; choose another name")
        self._sim.save(path)
        self._sessions.add(place)
        return f"the session is saved: cdpr run {out} repeats it"

    def _save_run(self, out: str = "") -> Later:
        """Write log, summary and scenario at once, and the report, which takes longer, later."""
        if not self._sim.samples:
            raise CdprError("save_run: no sample is complete before the first step")
        run = save(self._sim.so_far(), folder_name(out) if out else None, scenario=self.scenario.yaml_in)
        assert run.folder is not None
        if len(self._sim.events) > len(self.scenario.events):
            self._sim.save(Path(run.folder) / SESSION_NAME)
        return partial(_report, run, Path(run.folder))


def _latest(told: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """As many events as anyone reads: the last, and how many there are before."""
    earlier = len(told) - MOST
    return told if earlier <= 0 else [{"t": told[0]["t"], "text": f"{earlier} earlier events"}, *told[earlier:]]


def _report(run: Run, folder: Path) -> str:
    from cdpr.report.pages.run import write_report

    write_report(run, folder / "report.html")
    return f"the run is saved in {folder}"


def _wrench(push: Wrench) -> str:
    """A push in words."""
    parts = [(push.force, "N"), (push.moment, "N m")]
    return ", ".join(f"[{', '.join(f'{x:g}' for x in values)}] {unit}" for values, unit in parts if any(values))


__all__ = ["Stage"]
