"""Runs a scenario from start to end and keeps what was computed, however it ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cdpr.errors import (
    BeyondLimits,
    CdprError,
    Diverged,
    Infeasible,
    Interrupted,
    OutputError,
    PlantEnded,
    PluginError,
    Unanswered,
)
from cdpr.log.event import Event
from cdpr.log.recorder import Recorder
from cdpr.log.rows import LogRows
from cdpr.log.run import Header, Run
from cdpr.log.run_folder import RunFolder
from cdpr.model.reach import Reach
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.classes import innermost
from cdpr.plugins.registry import Role, describe, registry
from cdpr.scenario import Scenario, load_scenario
from cdpr.simulation.build import build, make_header
from cdpr.simulation.events import limit_events, marks, scheduled_events, tension_events
from cdpr.simulation.loop import Loop, Parts
from cdpr.simulation.room import check_room

STATUS: dict[type[BaseException], str] = {
    Diverged: "diverged",
    Infeasible: "infeasible",
    BeyondLimits: "beyond_limits",
    Unanswered: "unanswered",
    Interrupted: "interrupted",
    PlantEnded: "ended",
}


def simulate(
    scenario: str | os.PathLike[str] | Scenario,
    *,
    backend: str | type[Backend] | None = None,
    solver: str | type[TensionSolver] | None = None,
    controller: str | type[Controller] | None = None,
    overrides: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | RunFolder | None = None,
    real_time: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Run:
    """Simulate a scenario and return the run.

    Args:
        scenario: a scenario file, or what `load_scenario` returned.
        backend: which to use instead of the scenario's, by its name or as a class that need not be installed;
            likewise `solver` and `controller`. A class may hold `Options`, the model of its options, and `properties`.
        overrides: values by dotted key, such as {"simulation.duration": 2.0}, checked like the file.
        out: folder, new or empty, for log, resolved scenario and run.json; nothing is written unless it is given.
        real_time: no faster than the wall clock.
        progress: called now and then, at least every half second or step, with the number of samples done and their
            total; it may raise Interrupted to end the run.

    Raises:
        ScenarioError: the scenario is wrong.
        PluginError: a plugin is missing or broken.
        OutputError: `out` cannot be written.
        SimulationStopped: the run ended early: Infeasible (BeyondLimits where cables left theirs, Unanswered where
            the solver gave no valid answer), Diverged or (from `progress`) Interrupted.

    The attribute `run` of the error, also of a KeyboardInterrupt, holds all samples up to there.
    """
    changes = overrides or {}
    plugins = scenario.plugins if isinstance(scenario, Scenario) else registry()
    chosen: dict[str, str | None] = {}
    given: dict[Role, object] = {"backend": backend, "solver": solver, "controller": controller}
    for role, choice in given.items():
        if choice is not None and not isinstance(choice, str):
            plugins, choice = plugins.with_class(role, choice)
        chosen[role] = choice
    if isinstance(scenario, Scenario):
        scenario = scenario.with_changes(changes, **chosen, plugins=plugins)
    else:
        scenario = load_scenario(scenario, overrides=changes, **chosen, plugins=plugins)
    header = make_header(scenario)
    if isinstance(out, RunFolder):
        folder: RunFolder | None = out
    else:
        check_room(scenario, header, None if out is None else Path(out))
        folder = None if out is None else RunFolder(Path(out), header)
    attempt = _Attempt(scenario, header, folder)
    error: BaseException | None = None
    try:
        attempt.go(real_time, progress or (lambda done, total: None))
    except (CdprError, KeyboardInterrupt) as stop:
        error = stop
    except MemoryError:
        size = 8 * header.layout.width * (scenario.simulation.steps // header.log_every + 1) / 2**30
        error = CdprError(
            f"the {size:.3g} GiB of samples do not fit into memory: give a folder for the log, thin it by log.step or "
            "shorten simulation.duration"
        )
    except (Exception, SystemExit) as foreign:
        error = PluginError(f"{attempt.when}a plugin raised {describe(foreign)} in {_origin(foreign, scenario)}")
        error.__cause__ = foreign
    try:
        return attempt.end(error)
    except KeyboardInterrupt as again:
        if getattr(again, "run", None) is not None:
            raise
        return attempt.end(error or again)  # of a second signal: what it cut short is done; a third ends it at once


class _Attempt:
    """One run from its parts to its end; whatever happens, `end` keeps what there is."""

    def __init__(self, scenario: Scenario, header: Header, folder: RunFolder | None) -> None:
        self.scenario = scenario
        self.header = header
        self.folder = folder
        self.parts: Parts | None = None
        self.loop: Loop | None = None
        self.recorder: Recorder | None = None
        self.run: Run | None = None  # once all that it says is known
        self._closed: list[str] = []  # which parts need not be closed any more
        self._plugins: dict[str, Any] = {}  # what parts said of themselves
        self.begun = self.started = perf_counter()

    @property
    def time(self) -> float:
        """How far the run came, s."""
        return 0.0 if self.loop is None else self.loop.count * self.header.control_step

    @property
    def when(self) -> str:
        """Beginning of a message about the present moment."""
        return "" if self.recorder is None else f"t = {self.time:.6g} s: "

    def go(self, real_time: bool, progress: Callable[[int, int], None]) -> None:
        """Build, warm up and run."""
        self.parts = build(self.scenario)
        self.loop = Loop(self.parts)
        self.loop.warm_up(self.scenario.initial.state(), real_time)
        samples = self.scenario.simulation.steps + 1
        folder = None if self.folder is None else self.folder.path
        marked = marks(self.scenario.events, self.header.control_step)
        self.recorder = recorder = Recorder(self.header, samples - 1, folder, marked)
        progress(0, samples)
        self.started = perf_counter()

        def flush(k: int) -> None:
            recorder.flush(k)
            progress(k, samples)  # may raise Interrupted; the rows up to here are on disk

        self.loop.run(recorder.rows, flush, steps=samples - 1, real_time=real_time)

    def _reach(self, rows: Array | LogRows) -> Reach:
        """Where cables left their limits, of all samples."""
        assert self.recorder is not None
        if self.recorder.tally is not None:
            return self.recorder.tally.reach
        header, columns = self.header, self.header.layout.columns
        reach = Reach(header.bounds, len(header.cables), header.broken)
        length, rate = (np.ascontiguousarray(rows[:, columns[name]]) for name in ("length", "rate"))
        reach.add(np.ascontiguousarray(rows[:, columns["time"]][:, 0]), length, rate)
        return reach

    def end(self, error: BaseException | None) -> Run:
        """Close log, folder and backend, and return the run or raise the error with the run in it.

        Called again, it goes on where an interrupt cut it short.
        """
        if self.run is None:
            self.run, error = self._finished(error)
        if self.folder is not None:
            try:
                self.folder.finish(self.run)
            except OutputError as unwritable:
                error = error or unwritable
        if error is not None:
            error.run = self.run  # type: ignore[attr-defined]
            raise error
        return self.run

    def _finished(self, error: BaseException | None) -> tuple[Run, BaseException | None]:
        """Close log and backend; return the run and what it ended with, which may be what the log met."""
        looped = perf_counter()
        samples = 0 if self.loop is None else self.loop.count
        rows: Array | LogRows = np.empty((0, self.header.layout.width))
        counted: dict[str, Any] | None = None
        events: list[Event] = []
        if self.parts is not None and self.recorder is not None:
            try:
                self.recorder.close(samples)
            except OutputError as unwritable:
                error = unwritable
            rows = self.recorder.kept
            if self.recorder.tally is not None:
                counted = self.recorder.tally.figures()
            events = scheduled_events(self.parts.events, samples, self.recorder.marked, self.header)
            events += tension_events(self.recorder.status, self.header.control_step, self.parts)
            events += limit_events(self._reach(rows), self.header)
        plugins = self._plugins
        if self.parts is not None:
            events.sort(key=lambda event: event.time)
            parts: dict[str, Backend | Controller] = {
                "backend": self.parts.backend,
                "controller": self.parts.controller,
            }
            for role, part in parts.items():
                if role in self._closed:
                    continue
                self._closed.append(role)  # one that hangs is not asked twice
                try:
                    if about := part.describe():
                        plugins[role] = about
                    part.close()
                except (Exception, SystemExit) as foreign:
                    text = f"the {role} raised {describe(foreign)} while closing"
                    events.append(Event(self.time, "warning", text))
        if coupled := plugins.get("backend", {}).get("actuators"):
            events.insert(0, Event(0.0, "actuators", f"{coupled['coupling']}: {coupled['stability']}"))
        outcome, message = "finished", ""
        if error is not None:
            outcome = "interrupted" if isinstance(error, KeyboardInterrupt) else STATUS.get(type(error), "failed")
            message = str(error) or "interrupted"
            cause = error.__cause__
            if not isinstance(error, Infeasible):  # of that the last sample tells
                events.append(Event(self.time, outcome, str(cause) if isinstance(cause, CdprError) else message))
        return Run(
            header=self.header,
            rows=rows,
            status=outcome,
            message=message,
            events=tuple(events),
            timings={"setup_s": self.started - self.begun, "loop_s": looped - self.started},
            unused=self.scenario.unused,
            plugins=plugins,
            folder=None if self.folder is None else str(self.folder.path),
            counted=counted,
        ), error


def _origin(error: BaseException, scenario: Scenario) -> str:
    """Function, file and line where foreign code raised: in the file of a chosen plugin, where it came through that."""
    found = scenario.plugins
    chosen = [
        found.get("backend", scenario.simulation.backend),
        found.get("controller", scenario.controller.type),
        found.get("solver", scenario.solver.type),
    ]
    trace = innermost(error, [entry.file for entry in chosen]) or innermost(error)
    if trace is None:
        return "unknown code"
    code = trace.tb_frame.f_code
    return f"{code.co_name} ({Path(code.co_filename).name}:{trace.tb_lineno})"
