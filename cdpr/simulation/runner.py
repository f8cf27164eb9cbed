"""Execution of one run from its parts to its end; computed samples are always kept."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.errors import (
    CdprError,
    CollisionDetected,
    Diverged,
    Infeasible,
    Interrupted,
    LimitViolation,
    OutputError,
    PlantEnded,
    PluginError,
    SolverFailed,
    one_line,
)
from cdpr.link.waiting import report_line
from cdpr.log.clearance_rows import add_rows
from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.log.lost_steps import LostSteps, lost_steps
from cdpr.log.mcap_file import LOG_NAME
from cdpr.log.recorder import Recorder
from cdpr.log.rows import LogRows
from cdpr.log.run import CLEARANCE, Run
from cdpr.log.run_folder import IMAGES_NAME, RunFolder
from cdpr.log.summary import left_and_slack
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Controller
from cdpr.plugins.classes import innermost
from cdpr.scenario import Scenario
from cdpr.scenario.events import broken, guarding, redirected, redirecting
from cdpr.scenario.events.limit_changes import limit_changes
from cdpr.simulation.build import build
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.events import contact_events, limit_events, marks, scheduled_events, start_events, tension_events
from cdpr.simulation.far_start import far_start_events
from cdpr.simulation.loop import Loop
from cdpr.simulation.loop_part import LoopPart
from cdpr.simulation.parts import Parts
from cdpr.simulation.resting_start import warm_up
from cdpr.simulation.session import Session
from cdpr.simulation.works import with_live_events

if TYPE_CHECKING:
    from cdpr.log.image_writer import ImageWriter
    from cdpr.mechanics.closest import Closest

SESSION_NAME = "session.yaml"  # file in the output folder of a run with external commands

STATUS: dict[type[BaseException], str] = {
    Diverged: "diverged",
    Infeasible: "infeasible",
    LimitViolation: "beyond_limits",
    CollisionDetected: "touched",
    SolverFailed: "unanswered",
    Interrupted: "interrupted",
    PlantEnded: "ended",
}


class Runner:
    """Execution of one run: `begin` it, step the loop, and `end` it, also after an error.

    Attributes:
        loop: closed loop; made by `begin`.
        recorder: storage of the rows; made by `begin`.
        session: external commands and live events.
        run: result, once complete.
    """

    def __init__(self, scenario: Scenario, header: Header, folder: RunFolder | None) -> None:
        self.scenario = scenario
        self.header = header
        self.folder = folder
        self.parts: Parts | None = None
        self.loop: Loop | None = None
        self.recorder: Recorder | None = None
        self.run: Run | None = None
        self.session = Session(scenario)
        self._images: ImageWriter | None = None
        self._closed: list[str] = []  # parts that are closed already
        self._plugins: dict[str, Any] = {}  # metadata of the parts
        self._begun = self._started = perf_counter()

    def begin(self) -> tuple[Loop, Recorder]:
        """Build and warm up; return the loop and the recorder."""
        self.parts = build(self.scenario)
        self.loop = Loop(self.parts, self.session.record)
        warm_up(self.loop, self.scenario)
        folder = None if self.folder is None else self.folder.path
        marked = marks(self.scenario.events, self.header.control_step)
        self._open_images()
        self.recorder = Recorder(
            self.header, self.scenario.simulation.steps, folder, marked, self._watching, self._images
        )
        self._started = perf_counter()
        return self.loop, self.recorder

    def revise(self) -> None:
        """Replace the events by those of the session; past events are not repeated.

        Raises:
            CdprError: if the resulting motion is invalid; nothing has changed.
        """
        assert self.loop is not None
        assert self.recorder is not None
        events, step, motion = self.session.events, self.header.control_step, self.loop.parts.trajectory
        done, moving = redirecting(self.loop.parts.events), redirecting(events)
        if moving != done:
            more = moving[len(done) :]
            if moving[: len(done)] != done:
                motion, more = self.scenario.planned, moving
            motion = redirected(motion, more, step)
        self.loop.revise(events, motion)
        self.parts = self.loop.parts
        limits = limit_changes(events, self.scenario.robot, step)
        works = with_live_events(self.header, events)
        lost = broken(events, self.header.cables, step)
        self.header = replace(self.header, broken=lost, limit_changes=limits, works=works)
        self.recorder.amend(self.header, marks(events, step))
        if self.folder is not None:
            with suppress(OutputError):  # the end of the run reports a full disk
                self.folder.revise(self.header)

    def branch(self, folder: RunFolder) -> Runner:
        """Complete log and run.json at the present sample; return the execution that continues in another folder."""
        assert self.parts is not None
        assert self.loop is not None
        done = self.samples > self.scenario.simulation.steps
        stop = None if done else PlantEnded(f"t = {self._time:.6g} s: continues in {folder.path}")
        self.run, _ = self._finished(stop, closing=False)
        self._close_images()
        if self.folder is not None:
            self.folder.finish(self.run)
        new = Runner(self.scenario, self.header, folder)
        new.parts, new.loop, new.session, new._started = self.parts, self.loop, self.session, perf_counter()
        new._open_images()
        new.recorder = Recorder(
            self.header, self.scenario.simulation.steps, folder.path, closest=self._watching, images=new._images
        )
        self.loop.write_to(new.recorder.rows)
        return new

    def so_far(self) -> Run:
        """Return the run up to now; the simulation continues."""
        done = self.samples > self.scenario.simulation.steps
        stop = None if done else PlantEnded(f"t = {self._time:.6g} s: evaluated here, then continued")
        return self.run or self._finished(stop, closing=False, going_on=True)[0]

    @property
    def samples(self) -> int:
        """Return the number of complete samples."""
        return 0 if self.loop is None else self.loop.count

    def as_cdpr_error(self, error: BaseException) -> BaseException:
        """Return an exception as an error of cdpr; a foreign exception becomes a plugin's."""
        if isinstance(error, CdprError | KeyboardInterrupt):
            return error
        if isinstance(error, MemoryError):
            size = 8 * self.header.layout.width * (self.scenario.simulation.steps // self.header.log_every + 1) / 2**30
            return CdprError(
                f"the {size:.3g} GiB of samples do not fit into memory: give a folder for the log, thin it by log.step "
                "or shorten simulation.duration"
            )
        when = "" if self.recorder is None else f"t = {self._time:.6g} s: "
        wrapped = PluginError(f"{when}a plugin raised {one_line(error)} in {_origin(error, self.scenario)}")
        wrapped.__cause__ = error
        return wrapped

    def end(self, error: BaseException | None) -> Run:
        """Close log, folder and backend; return the run or raise the error with the run attached.

        A second interrupt during this is handled after the step that it cut short; a third one ends the process at
        once.
        """
        try:
            return self._end(error)
        except KeyboardInterrupt as again:
            if getattr(again, "run", None) is not None:
                raise
            return self._end(error or again)

    @property
    def _time(self) -> float:
        """Return the time of the last sample, s."""
        return self.samples * self.header.control_step

    def _end(self, error: BaseException | None) -> Run:
        """Do the work of `end`; a second call continues after an interrupt."""
        if self.run is None:
            self.run, error = self._finished(error)
        if self.folder is not None and not len(self.run.rows) and isinstance(error, CdprError):
            with suppress(CdprError):
                self._close_images()
            self.folder.withdraw(
                LOG_NAME, SESSION_NAME, IMAGES_NAME
            )  # nothing was computed: the corrected command may use the same folder
            self.folder, self.run = None, replace(self.run, folder=None)
        if self.folder is not None:
            try:
                self._close_images()
            except CdprError as unseen:
                error = error or unseen
            try:
                self.folder.finish(self.run)
            except OutputError as unwritable:
                error = error or unwritable
        if error is not None:
            error.run = self.run  # type: ignore[attr-defined]
            raise error
        return self.run

    def _open_images(self) -> None:
        """Begin the file with the images of cameras, so that a run without a renderer fails at its start."""
        if self.folder is None or not self.header.imaging:
            return
        from cdpr.log.image_writer import ImageWriter  # few runs need this import

        self._images = ImageWriter(self.folder.path / IMAGES_NAME, self.header)

    def _close_images(self) -> None:
        """Wait for the last images, and complete their file; an interrupt skips them."""
        if self._images is None:
            return
        assert self.run is not None
        assert self.folder is not None
        try:
            skipped = self._images.close(partial(self._report_images, self.folder.path))
        except CdprError as error:
            self._images = None
            self._add_warning(str(error))
            raise
        self._images = None
        if skipped:
            self._add_warning(f"{_images(skipped)} not rendered: `cdpr repair {self.folder.path}` renders them")

    def _report_images(self, folder: Path, count: int) -> None:
        again = "again " if self.run is not None and self.run.status == "interrupted" else ""
        report_line(
            f"writing {_images(count)}; Ctrl-C {again}skips them, and `cdpr repair {folder}` renders them later"
        )

    def _add_warning(self, text: str) -> None:
        assert self.run is not None
        self.run = replace(self.run, events=(*self.run.events, Event(self._time, "warning", text)))

    def _finished(
        self, error: BaseException | None, *, closing: bool = True, going_on: bool = False
    ) -> tuple[Run, BaseException | None]:
        """Close log and, if `closing`, the backend; return the run and its final error, which may come from the log.

        With `going_on`, the run continues with its log, and nothing is closed.
        """
        looped = perf_counter()
        samples = self.samples
        rows: Array | LogRows = np.empty((0, self.header.layout.width))
        counted: dict[str, Any] | None = None
        clearance: dict[str, Any] = {}
        events: list[Event] = []
        if self.parts is not None and self.recorder is not None:
            try:
                rows = self.recorder.so_far(samples) if going_on else self.recorder.close(samples)
            except OutputError as unwritable:
                error, rows = unwritable, self.recorder.kept
            fault = self.recorder.finite.fault
            if fault and not going_on and (error is None or isinstance(error, PlantEnded)):
                error = Diverged(f"t = {self._time:.6g} s: {fault}")
            if self.recorder.tally is not None:
                counted = self.recorder.tally.figures()
            events = scheduled_events(self.parts.events, samples, self.recorder.marked, self.header)
            refusal = self.loop.stage.refusal if self.loop else ""
            events += tension_events(self.recorder.status, self.header.control_step, self.parts, refusal)
            tally = self.recorder.tally
            known = None if tally is None else (tally.beyond, tally.slack)
            left, slack = known or left_and_slack(self.header, np.asarray(rows))
            events += limit_events(left.exceeded(), self.header)
            events += slack.events(self.header.cables)
            lost = lost_steps(LostSteps(), self.header, np.asarray(rows)) if tally is None else tally.lost
            events += lost.events(self.header.cables)
            if len(rows):
                first = np.asarray(rows[:1])[0]
                events += start_events(first, self.header, self.parts)
                events += far_start_events(self.scenario, first[self.header.layout.span("position", "orientation")])
            closest = self._closest(rows)
            if closest is not None:
                least = closest.least
                if least is not None:
                    values = least.clearance, least.time, closest.name(least)
                    clearance = dict(zip(CLEARANCE, values, strict=True))
                events += contact_events(closest, guarding(self.parts.events, self.header.control_step))
            events += self.session.command_events(samples)
            if self.folder is not None and self.session and not going_on:
                try:
                    self.session.save(self.folder.path / SESSION_NAME, samples)
                except CdprError as unsaved:
                    events.append(Event(self._time, "warning", f"{SESSION_NAME} is not written: {unsaved}"))
        if self.parts is not None:
            events.sort(key=lambda event: event.time)
            for name, part in self.parts.named:
                if not isinstance(part, LoopPart):  # a plugin: it is described as it is closed, once
                    if name in self._closed or not closing:
                        continue
                    self._closed.append(name)  # do not wait twice for a part that hangs
                events += self._complete(name, part)
        if coupled := self._plugins.get("backend", {}).get("actuators"):
            events.insert(0, Event(0.0, "actuators", f"{coupled['coupling']}: {coupled['stability']}"))
        outcome, message = "finished", ""
        if error is not None:
            outcome = "interrupted" if isinstance(error, KeyboardInterrupt) else STATUS.get(type(error), "failed")
            message = str(error) or "interrupted"
            cause = error.__cause__
            if not isinstance(error, Infeasible):  # the last sample contains the reason
                events.append(Event(self._time, outcome, str(cause) if isinstance(cause, CdprError) else message))
        return Run(
            header=self.header,
            rows=rows,
            status=outcome,
            message=message,
            events=tuple(events),
            timings={"setup_s": self._started - self._begun, "loop_s": looped - self._started},
            unused=self.scenario.unused,
            plugins=self._plugins,
            interpreted=None if self.loop is None else self.loop.pipeline.interpreted,
            folder=None if self.folder is None or going_on else str(self.folder.path),
            counted=counted,
            clearance=clearance,
        ), error

    def _complete(self, name: str, part: Backend | Controller | LoopPart) -> list[Event]:
        """Store the metadata of a part, and close a plugin; return warnings if it raises."""

        def describe() -> None:
            if about := part.describe():
                json.dumps(about, allow_nan=False)  # `run.json` will contain it
                self._plugins[name] = about

        found = []
        for do in (describe, part.close):
            try:
                do()
            except KeyboardInterrupt:
                raise
            except BaseException as foreign:
                found.append(Event(self._time, "warning", f"the {name} raised {one_line(foreign)} while closing"))
        return found

    def _closest(self, rows: Array | LogRows) -> Closest | None:
        """Return the smallest distances of cables to obstacles in all samples; None if cable diameters are unknown."""
        assert self.recorder is not None
        if self.recorder.tally is not None:
            return self.recorder.tally.closest
        closest = self._watching()
        if closest is not None:
            add_rows(closest, self.header.layout, np.asarray(rows))
        return closest

    def _watching(self) -> Closest | None:
        """Return the observer of the distances of cables to obstacles."""
        robot = self.scenario.robot
        if any(cable.diameter is None for cable in robot.cables):
            return None
        from cdpr.mechanics.clearance import clearance  # few runs need this import
        from cdpr.mechanics.closest import Closest, Level

        assert self.parts is not None
        levels = [Level(one.clearance, one.after) for _, one in guarding(self.parts.events, self.header.control_step)]
        among = clearance(robot, self.scenario.obstacles, gravity=self.header.gravity)
        return Closest(among, self.header.broken, levels)


def _images(count: int) -> str:
    return f"{count} image{'s' * (count != 1)}"


def _origin(error: BaseException, scenario: Scenario) -> str:
    """Return function, file and line where foreign code raised, preferably in the file of a chosen plugin."""
    trace = innermost(error, [entry.file for entry in chosen_plugins(scenario).values()]) or innermost(error)
    if trace is None:
        return "unknown code"
    code = trace.tb_frame.f_code
    return f"{code.co_name} ({Path(code.co_filename).name}:{trace.tb_lineno})"
