"""The loop: state, desired, wrench, tension, one row, one step of the plant; again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from time import monotonic
from typing import Any

import numpy as np

from cdpr.errors import BackendDied, Diverged, Infeasible, PluginError, SimulationStopped
from cdpr.model.robot import Array, read_only
from cdpr.plugins.controller import Output
from cdpr.plugins.snapshots import Saved, put_back, save
from cdpr.scenario.events import ScenarioEvent
from cdpr.simulation.faults import told
from cdpr.simulation.loads import Loads
from cdpr.simulation.pace import Pace
from cdpr.simulation.parts import Parts
from cdpr.simulation.playback import Playback
from cdpr.simulation.sample import Sample
from cdpr.simulation.schedule import Schedule
from cdpr.tension.command import CommandStage
from cdpr.tension.stage import Asked, TensionStage
from cdpr.tension.status import Status
from cdpr.trajectory import Trajectory

# An engine's clock is a sum of steps: after 1e8 of them it may be off by this share. A reset is off by much more.
CLOCK_TOLERANCE = 1e-6

# After these a solver need not have written any tensions.
ANSWERS = (Status.OK, Status.INFEASIBLE, Status.UNSUPPORTED)


@dataclass(frozen=True, eq=False)
class Moment:
    """All that the future of a loop depends on, between two samples."""

    count: int
    time: float
    due: int
    live: Saved
    own: list[Any]  # of the parts


class Loop:
    """A closed loop, ready to run.

    Attributes:
        row: the present sample, columns as `cdpr.log.layout` says; the parts work on views of it.
        out: where the controller writes: the wrench (6,) or the commands (m,).
        time: of the sample that is looked at, s.
        count: how many samples are complete.
        due: the next sample at which something happens.
    """

    def __init__(self, parts: Parts) -> None:
        self.parts = parts
        self.count, self.last, self.time, self.due = 0, 0, 0.0, 0
        self.decide: Callable[..., None]
        self.advance: Callable[[], None]
        self.present = present = Sample(parts)
        self.layout, self.row = present.layout, present.row
        self.state, self.desired = present.state, present.desired
        self.wrench, self.tension, self.W = present.live.wrench, present.live.tension, present.live.W
        # What the controller sees of them it cannot change.
        self.given_state, self.given_desired = read_only(self.state), read_only(self.desired)
        self.sample = parts.trajectory.sampler(self.desired)
        self._outside: dict[Output, tuple[TensionStage | CommandStage, Array, Callable[[], None]]] = {}
        self.stage = self._stage(parts.output)
        self.out = self._written(self.stage)
        loads = Loads(present.view("external"), parts.backend.external)
        self.schedule = Schedule(parts.events, parts.control_step, parts.robot, self.stage, loads, parts.settings)
        self.observe, self.observe_start = present.looking(parts.control_step), present.looking(0.0)
        self.distribute = self._through(self.stage)

    def warm_up(self, start: Array, real_time: bool = False) -> None:
        """Call every part once and put all back to `start` (13,).

        What a first call costs (compiling, loading from disk) is then over before a clock runs; in real time also that
        of the infeasible policy. Raises PluginError where controller or solver write nothing.
        """
        parts = self.parts
        try:
            self._first()
            self.sample(0.0)
            self.out[:] = np.nan
            parts.controller.control(0.0, self.given_state, self.given_desired, self.out)
            if np.isnan(self.out).all():
                raise PluginError(
                    f"the controller wrote no {parts.output}: `control` must write into the array it is given"
                )
            self.stage.distribute()
            if self.present.live.status[0] not in ANSWERS and not self.stage.answered:
                raise PluginError(
                    f"solver '{parts.solver_name}' wrote no tensions, or NaN: `solve` must write "
                    "into the array it is given"
                )
            if real_time:
                self.stage.warm_up_policy()
            self.schedule.warm_up()
            parts.backend.command[...] = self.tension
            parts.backend.read_tension(self.tension)
            parts.backend.step(parts.substeps)
            self.observe()
        except BackendDied:
            raise  # it would only die again, or hang as long again
        except SimulationStopped:
            pass  # the run itself will say so, at its proper time
        self.row[:] = 0.0
        self.row[self.layout.added] = np.nan  # until somebody writes
        self.stage.forget()
        self.stage.refusal = ""
        parts.controller.reset()
        parts.solver.reset()
        parts.backend.command[...] = 0.0
        parts.backend.reset(start)

    def begin(self, rows: Array, last: int) -> None:
        """Look at sample 0, at the backend's present state; from then on `decide` and `advance` make a step.

        `decide` completes sample `count`, which goes into `rows[count % len(rows)]`; `advance` takes the plant to the
        next and looks: at its state, at what happens, at what is desired. `last` is the number of the last sample;
        where there are fewer rows, their number is a multiple of 256. Both raise SimulationStopped; a sample that tells
        why there are no tensions is complete all the same.
        """
        self.write_to(rows)
        self.count, self.last, self.time = 0, last, 0.0
        self._first()
        self.due = self.schedule.begin()
        self.row[0] = 0.0
        if self.due == 0:
            self.due = self.schedule.act(0)
        self.sample(0.0)

    def revise(self, events: Sequence[ScenarioEvent], motion: Trajectory) -> None:
        """Go on with these events and the motion as they make it; what has happened is not done again."""
        self.parts = replace(self.parts, events=tuple(events), trajectory=motion)
        self.sample = motion.sampler(self.desired)
        self.schedule.plan(events)
        self._outside.clear()
        self.distribute = self._through(self.stage)
        self.write_to(self._rows)

    def join(self, event: ScenarioEvent) -> None:
        """Let happen what an event, of which `revise` knows, does at the present sample, which is not yet decided."""
        k = self.count
        self.schedule.join(event, k)
        self.due = self.schedule.push(k)
        self.sample(self.time)

    def write_to(self, rows: Array) -> None:
        """Put the samples into `rows` from now on.

        (The halves of a step are functions over what they need: to look it up in this object would cost as much as a
        kernel.)
        """
        self._rows = rows
        parts, row, size = self.parts, self.row, len(rows)
        backend, substeps, period = parts.backend, parts.substeps, parts.control_step
        state, desired, out = self.given_state, self.given_desired, self.out
        tension, command, step = self.tension, backend.command, backend.step
        sample, control, distribute, act = self.sample, parts.controller.control, self.distribute, self.schedule.act
        observe, clock = self.observe, backend.engine_time

        def decide(given: Callable[[], None] | None = None) -> None:
            k = self.count
            try:
                if given is None:
                    control(self.time, state, desired, out)
                    distribute()
                else:
                    given()
            except Infeasible:
                rows[k % size] = row  # this sample tells why
                self.count = k + 1
                raise
            rows[k % size] = row
            self.count = k + 1

        def advance() -> None:
            command[...] = tension
            k = self.count
            self.time = time = k * period
            step(substeps)
            fault = observe()
            if fault:
                self._check(fault)
            reading = clock()
            if reading is not None and not abs(reading - time) <= CLOCK_TOLERANCE * time:
                raise Diverged(f"the engine's clock reads {reading:.6g} s: it reset itself")
            row[0] = time
            if k == self.due:
                self.due = act(k)
            sample(time)

        playback = Playback(parts.events, period, self.give)

        def decide_as_given(given: Callable[[], None] | None = None) -> None:
            decide(given or playback.at(self.count))

        self.decide, self.advance = decide_as_given if playback else decide, advance

    def run(
        self, rows: Array, flush: Callable[[int], None], *, steps: int | None = None, real_time: bool = False
    ) -> int:
        """Fill `rows` (steps + 1, width) from the backend's present state; return the number of samples made.

        Fewer rows, a multiple of 256, are filled again and again, where `steps` says how many there are to make.
        `flush` and `real_time` are those of a `Pace`; `flush` may end the run by raising SimulationStopped. Raises
        that, with the time in its text, where the run stops early; `count` then tells how many samples are complete.
        """
        pace = Pace(flush, real_time)
        with self.timed():
            self.begin(rows, len(rows) - 1 if steps is None else steps)
        self.go(self.last, pace)
        with self.timed():
            self.decide()
        return self.count

    def go(self, k: int, pace: Pace) -> None:
        """Complete the samples before sample k, and look at that; raises as `run`."""
        decide, advance = self.decide, self.advance
        try:
            while self.count < k:
                decide()
                advance()
                if self.count >= pace.count or monotonic() > pace.due:
                    pace.after(self.count, self.time)
        except (SimulationStopped, PluginError) as stop:  # as `timed`, which costs a tenth of a step that is alone
            raise self._dated(stop) from stop

    @contextmanager
    def timed(self) -> Iterator[None]:
        """Put the time before what ends a run."""
        try:
            yield
        except (SimulationStopped, PluginError) as stop:
            raise self._dated(stop) from stop

    def _dated(self, stop: SimulationStopped | PluginError) -> SimulationStopped | PluginError:
        return type(stop)(f"t = {self.time:.6g} s: {stop}")

    def give(self, output: Output, values: Array) -> Callable[[], None]:
        """Return what decides a step in place of the controller: a wrench to distribute, or the command of each cable.

        For `decide`; `values` is (6,) or (m,), live.
        """
        if output not in self._outside:
            stage = self.stage if output == self.parts.output else self._stage(output)
            self._outside[output] = stage, self._written(stage), self._through(stage)
        stage, out, distribute = self._outside[output]

        def given() -> None:
            out[:] = values
            if self.count:
                stage.follow()
            else:
                stage.forget()
            distribute()
            self.stage.follow()

        def same() -> None:
            out[:] = values
            distribute()

        return same if stage is self.stage else given

    def snapshot(self) -> Moment:
        """Return all that the samples after the present one depend on, to be taken between them.

        Raises PluginError where a part of the loop cannot take one.
        """
        parts, backend = self.parts, self.parts.backend
        live = save((self.row, self.W, self.present.true_W, backend.command, backend.external))
        own = [part.snapshot() for part in (backend, parts.controller, parts.solver, self.stage, self.schedule)]
        return Moment(self.count, self.time, self.due, live, own)

    def restore(self, snapshot: Moment) -> None:
        """Go back to a snapshot of this loop: what follows is the same to the bit. Raises PluginError likewise."""
        parts, backend = self.parts, self.parts.backend
        owners = (backend, parts.controller, parts.solver, self.stage, self.schedule)
        for part, taken in zip(owners, snapshot.own, strict=True):
            part.restore(taken)
        put_back(snapshot.live, (self.row, self.W, self.present.true_W, backend.command, backend.external))
        self.count, self.time, self.due = snapshot.count, snapshot.time, snapshot.due

    def _stage(self, output: Output) -> TensionStage | CommandStage:
        """Make what takes the output of a controller; all share the cables."""
        parts = self.parts
        if output == "command":
            return CommandStage(parts.controlled, parts.policy, self.present.live, self.present.cables)
        asked = Asked(parts.solver.solve, parts.solver_name, parts.respects_bounds, parts.policy)
        return TensionStage(parts.controlled, asked, self.present.live, self.present.cables)

    def _written(self, stage: TensionStage | CommandStage) -> Array:
        """What is written for a stage: commands (m,) or the wrench (6,)."""
        return stage.command if isinstance(stage, CommandStage) else self.wrench

    def _through(self, stage: TensionStage | CommandStage) -> Callable[[], None]:
        """What completes a sample, given what is written for the stage."""
        return self.present.completing(self.schedule.through(stage), self.parts.events)

    def _first(self) -> None:
        self.state[:] = self.parts.backend.state
        self._check(self.observe_start())

    def _check(self, fault: int) -> None:
        if fault:
            parts, k = self.parts, self.count
            state = self.layout.span("position", "angular_velocity")
            before = self._rows[(k - 1) % len(self._rows), state] if k else None
            raise Diverged(told(fault, parts.robot, parts.believed, parts.backend.state, before, parts.control_step))
