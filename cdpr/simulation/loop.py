"""Control loop: state, desired motion, wrench, tension, one row, one step of the plant; repeat."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from time import monotonic

import numpy as np

from cdpr.base.errors import BackendDied, Diverged, PluginError, SimulationStopped
from cdpr.log.blocks import BLOCK
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.plugins import Controller, TensionSolver
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.controller import Output
from cdpr.scenario.events import ScenarioEvent
from cdpr.simulation.attached import LoopBodies
from cdpr.simulation.clock import next_portion
from cdpr.simulation.controller_calls import ControllerCalls
from cdpr.simulation.external_command import ExternalCommands
from cdpr.simulation.faults import NO_LENGTH_NOMINAL, fault_message
from cdpr.simulation.finite_limits import check_limits
from cdpr.simulation.loads import Loads
from cdpr.simulation.moment import Memory, Moment
from cdpr.simulation.pace import Pace
from cdpr.simulation.parts import Parts
from cdpr.simulation.pipeline import Pipeline
from cdpr.simulation.plant import clock_operations, moving
from cdpr.simulation.playback import Playback
from cdpr.simulation.record import Record
from cdpr.simulation.sample import Sample
from cdpr.simulation.schedule import Schedule
from cdpr.simulation.sensors import disturb_of
from cdpr.simulation.winding import Winding
from cdpr.tension.command import CommandStage
from cdpr.tension.operations import Operation, perform
from cdpr.tension.stage import StageSolver, TensionStage
from cdpr.tension.status import Status
from cdpr.trajectory import Trajectory

# Longest duration of a call of the compiled loop: interrupts wait for its end.
BRIEF = 0.02  # s

# With these statuses a solver need not have written tensions.
ANSWERS = (Status.OK, Status.INFEASIBLE, Status.UNSUPPORTED)


class Loop:
    """Closed loop, ready to run.

    Args:
        parts: parts of the loop.
        record: record of external commands.

    Attributes:
        parts: parts of the loop.
        pipeline: pipeline of a step.
        stage: distribution of the controller's wrench, or check of its commands.
        advancing: operations that take the plant to the next sample.
        row: present sample, columns as `cdpr.log.layout` defines; the parts work on views of it.
        out: output of the controller: the wrench (6,) or the commands (m,).
        outside: commands that replace the answers of controller or solver.
        calls: calls of the controller.
    """

    def __init__(self, parts: Parts, record: Record | None = None) -> None:
        self.parts, self._record = parts, record or Record()
        self.last = 0
        self.present = present = Sample(parts)
        self.layout, self.row = present.layout, present.row
        self.state, self.desired = present.state, present.desired
        self.wrench, self.tension, self.W = present.live.wrench, present.live.tension, present.live.W
        # The controller cannot change its inputs.
        self.given_state, self.given_desired = read_only(present.seen), read_only(self.desired)
        self.sample = parts.trajectory.sampler(self.desired)
        self.calls = ControllerCalls(parts, present)
        self.winding = Winding(parts, present)
        self.stage = self.stage_of(parts.output)
        self.out = self.written(self.stage)
        loads = Loads(present.view("external"), parts.backend.external)
        attached = LoopBodies(parts, present, self._rebind)
        about = parts.control_step, parts.robot, self.stage, loads, parts.settings, attached, present.locked
        self.schedule = Schedule(parts.events, *about, present.drive, self.winding.brakes, disturb_of(parts.more))
        self._memory = Memory(parts, present, self.stage, self.schedule, self.calls)
        # Operations that observe the plant, and the first such: made once, as the geometry of pulleys is expensive.
        self._looking, self._looking_first = (present.observing(h, self._check) for h in (parts.control_step, 0.0))
        self._plan()

    @property
    def count(self) -> int:
        """Return the number of complete samples."""
        return self.pipeline.count

    @property
    def time(self) -> float:
        """Return the time of the present sample, s."""
        return self.pipeline.time

    def warm_up(self, start: Array) -> None:
        """Call every part once, so that costs of first calls do not count as run time; then reset all to `start` (13,).

        Raises:
            PluginError: if controller or solver writes nothing.
            ScenarioError: if the solver requires finite limits of the tensions.
        """
        parts = self.parts
        try:
            self.observe()
            self.sample(0.0)
            if "controller" not in parts.live:
                self._try_control()
            self.schedule.warm_up()
            if "backend" not in parts.live:
                perform([*self.winding.reading(), *self.winding.commanding(self.stage)])
                parts.backend.command[...] = self.winding.drive
                parts.backend.read_tension(self.tension)
                parts.backend.step(parts.substeps)
                perform(self._looking)
        except BackendDied:
            raise  # it would only die again, or hang as long again
        except SimulationStopped:
            pass  # the run itself reports this at its time
        self.reset(start)

    def reset(self, start: Array) -> None:
        """Reset all parts, the plant to the state `start` (13,)."""
        self.row[:] = 0.0
        self.row[self.layout.added] = np.nan  # until a part writes
        self._memory.reset(start)

    def _try_control(self) -> None:
        self.out[:] = np.nan
        perform(self.pipeline.operations[:1])
        if np.isnan(self.out).any():
            raise PluginError(
                f"the controller wrote no {self.parts.output_name}, or NaN: `control` must write all of the given "
                "array. If it does, check tensions at the start by `cdpr info` and the mass and weight of cables"
            )
        if isinstance(self.stage, TensionStage):
            parts, limits = self.parts, self.present.cables.limits
            check_limits(parts.controlled_robot, parts.solver, parts.solver_name, limits, self.W, self.wrench)
        self.stage.distribute()
        if self.present.live.status[0] not in ANSWERS and not self.stage.answered:
            raise PluginError(self.stage.unanswered())

    def begin(self, rows: Array, last: int) -> None:
        """Observe sample 0, at the backend's present state; then `decide` and `advance` make a step.

        `decide` completes sample `count`, which goes into `rows[count % len(rows)]`. `advance` takes the plant to the
        next sample and updates state, events and desired motion. `last` is the number of the last sample; with fewer
        rows, their number is a multiple of 256.

        Raises:
            SimulationStopped: by both; a sample without valid tensions is complete all the same.
        """
        self.write_to(rows)
        self.last = last
        self.pipeline.place = 0, 0, 0.0, 0
        self.row[0] = 0.0
        self.observe()
        self.pipeline.due = self.schedule.begin()
        if self.pipeline.due == 0:
            self._happen()
        if self.winding.needs_start:
            self.winding.hold(self.stage_of("wrench"))
        self._refresh()
        self.sample(0.0)

    def revise(self, events: Sequence[ScenarioEvent], motion: Trajectory) -> None:
        """Replace events and motion; past events are not repeated."""
        self.parts = replace(self.parts, events=tuple(events), trajectory=motion)
        self.calls.follow(motion, self.parts.planned, events)
        self.sample = motion.sampler(self.desired)
        self.schedule.plan(events)
        self._plan(self.pipeline)

    def follow(self, motion: Trajectory) -> bool:
        """Follow another motion from the next sample on; return False if its sampler needs Python."""
        self.sample = motion.sampler(self.desired)
        self.calls.follow(motion, motion, ())
        before, self.advancing[-1] = self.advancing[-1], Operation("trajectory", self.sample, timed=True)
        return all(pipeline.swap(before, self.advancing[-1]) for pipeline in self._pipelines())

    def join(self, event: ScenarioEvent) -> None:
        """Apply an event, already added by `revise`, at the present sample before its decision."""
        self.schedule.join(event, self.count)
        self.push()
        self._refresh()
        self.sample(self.time)

    def push(self) -> None:
        """Update the external wrench of the present sample from the events."""
        self.pipeline.due = self.schedule.push(self.count)

    def write_to(self, rows: Array) -> None:
        """Write the samples into `rows` from now on."""
        for pipeline in self._pipelines():
            if pipeline.rows is not rows:
                pipeline.rows = rows

    def decide(self, given: Pipeline | None = None) -> None:
        """Complete the present sample; with the pipeline of an external command, if given."""
        if given is None and self._playback is not None:
            given = self._playback.at(self.count)
        if given is None:
            self.pipeline.decide()
        else:
            try:
                given.decide()
            finally:
                self.pipeline.mark_complete()

    def advance(self) -> None:
        """Take the plant to the next sample, and observe it."""
        self.pipeline.run_until(self.count)

    def run(self, rows: Array, flush: Callable[[int], None], *, steps: int | None = None, block: int = BLOCK) -> int:
        """Fill `rows` (steps + 1, width) from the backend's present state; return the number of complete samples.

        Fewer rows, a multiple of 256, are filled repeatedly; `steps` is then the number of control steps. `flush`
        and `block` are those of a `Pace`; `flush` may end the run by raising SimulationStopped.

        Raises:
            SimulationStopped: if the run stops early; its text contains the time, and `count` is the number of complete
                samples.
        """
        pace = Pace(flush, block)
        with self.timed():
            self.begin(rows, len(rows) - 1 if steps is None else steps)
        self.go(self.last, pace)
        with self.timed():
            self.decide()
        return self.count

    def go(self, k: int, pace: Pace, given: Pipeline | None = None) -> None:
        """Complete the samples before sample k, and observe that one; errors as for `run`, `given` as for `decide`."""
        pipeline, most = given or self.pipeline, 1
        try:
            while (count := pipeline.count) < k:
                if given is None and self._playback is not None:
                    self.decide()
                    self.advance()
                elif k - count == 1:
                    pipeline.run_until(k)
                else:
                    start = monotonic()
                    pipeline.run_until(min(k, max(pace.count, count + 1), count + most))
                    most = next_portion(most, monotonic() - start, BRIEF, pace.block)
                if pipeline.count >= pace.count or monotonic() > pace.due:
                    pace.after(pipeline.count)
        except (SimulationStopped, PluginError) as stop:  # as `timed`, which costs as much as a single step
            raise self._dated(stop) from stop

    @contextmanager
    def timed(self) -> Iterator[None]:
        """Add the time to an error that ends a run."""
        try:
            yield
        except (SimulationStopped, PluginError) as stop:
            raise self._dated(stop) from stop

    def _dated(self, stop: SimulationStopped | PluginError) -> SimulationStopped | PluginError:
        return type(stop)(f"t = {self.time:.6g} s: {stop}")

    def _pipelines(self) -> Iterator[Pipeline]:
        yield self.pipeline
        yield from self.outside.pipelines

    def snapshot(self) -> Moment:
        """Return a snapshot of the loop, taken between two samples.

        Raises:
            PluginError: if a part does not support it.
        """
        return self._memory.take(self.pipeline.place)

    @property
    def memory(self) -> tuple[Array, ...] | None:
        """Return the arrays that steps change and need, the row first; None if a part has other state.

        Changes by events are not included.
        """
        return None if self._playback is not None else self._memory.arrays

    def restore(self, snapshot: Moment) -> None:
        """Restore a snapshot of this loop; the following samples have the same bits.

        Raises:
            PluginError: if a part does not support it.
        """
        self.schedule.load(snapshot.count)  # the parts have the mass of that time when they restore their states
        self._memory.put_back(snapshot)
        self.pipeline.place = snapshot.place
        self._refresh()

    def close(self) -> None:
        """Release all parts: operations and loop refer to each other, and many loops are made one after another."""
        vars(self.pipeline).clear()
        vars(self).clear()

    def stage_of(self, output: Output) -> TensionStage | CommandStage:
        """Return the stage for the output of a controller; all stages share the cables."""
        parts = self.parts
        if output != "wrench":
            about = parts.controlled_robot, parts.policy, self.present.live, self.present.cables
            commanded = self.winding.stage() if output == "winch" else CommandStage(*about)
            self.calls.record(commanded)
            return commanded
        solver = parts.solver
        known = isinstance(solver, TensionSolver) and speaks_for(solver.compiled, solver.solve)
        compiled = solver.compiled if known else None
        stage_solver = StageSolver(solver.solve, parts.solver_name, parts.respects_bounds, parts.policy, compiled)
        stage = TensionStage(parts.controlled_robot, stage_solver, self.present.live, self.present.cables)
        self.calls.correct(stage)
        self.calls.record(stage)
        return stage

    def written(self, stage: TensionStage | CommandStage) -> Array:
        """Return the input of a stage: commands (m,) or the wrench (6,)."""
        return stage.command if isinstance(stage, CommandStage) else self.wrench

    def through(self, stage: TensionStage | CommandStage) -> list[Operation]:
        """Return the operations that complete a sample from the input of the stage."""
        winding = self.winding
        distributing = [*winding.reading(), *self.schedule.through(stage), *winding.commanding(stage)]
        return [*self.present.completing(distributing, self.parts.events), *winding.starting(stage)]

    def _plan(self, before: Pipeline | None = None) -> None:
        """Make the pipeline of a step; it continues at the position of `before`."""
        parts, backend, controller = self.parts, self.parts.backend, self.parts.controller
        given = self.given_state, self.given_desired, self.out
        known = isinstance(controller, Controller) and speaks_for(controller.compiled, controller.control)
        law = controller.compiled(*given) if known and self.calls.period == 1 else None
        control = controller.control if self.calls.period == 1 else self.calls.decide

        def decide(time: float) -> None:
            control(time, *given)

        deciding = (
            Operation("controller", law, self._refuse_code) if law else Operation("controller", decide, timed=True)
        )
        self._moving = moving([backend], parts.substeps)
        reading_clock, checking_clock = clock_operations(backend)
        self.advancing = [
            Operation("command", bind("copy", source=self.winding.drive, target=backend.command)),
            *self._moving,
            *(each for part in parts.more for each in part.moved()),
            *reading_clock,
            Operation("time", bind("stamp", row=self.row), timed=True),
            *self._looking,
            *checking_clock,
            Operation("events", self._happen, due=True),
            Operation("trajectory", self.sample, timed=True),
        ]
        checking = Operation("controller", bind("not_finite", values=self.out), self._refuse_output)
        operations = [deciding, checking, *self.through(self.stage)]
        self.pipeline = Pipeline(operations, self.advancing, self.row, parts.control_step, before)
        self.outside = ExternalCommands(self, self._record)
        playback = Playback(parts.events, parts.control_step, self.outside.command)
        self._playback = playback if playback else None

    def _rebind(self) -> None:
        """Take the compiled operations of the backend again, which may depend on the mass of the platform."""
        first = self.advancing.index(self._moving[0])
        again = moving([self.parts.backend], self.parts.substeps)
        for at, (before, now) in enumerate(zip(self._moving, again, strict=True)):
            if now.do is not before.do and all(pipeline.swap(before, now) for pipeline in self._pipelines()):
                self.advancing[first + at] = self._moving[at] = now

    def _refuse_code(self, code: int) -> None:
        raise PluginError(f"the controller's compiled operation returned {code}; expected 0")

    def _refuse_output(self, _: int) -> None:
        values = ", ".join(f"{value:.4g}" for value in self.out)
        raise Diverged(f"the controller's {self.parts.output_name} is not finite: [{values}]; smaller gains may help")

    def _happen(self) -> None:
        """Apply the events that are due at the present sample."""
        self.pipeline.due = self.schedule.apply(self.count)
        self._refresh()

    def _refresh(self) -> None:
        """Update for all operations whether they run from now on."""
        for pipeline in self._pipelines():
            pipeline.refresh()

    def observe(self) -> None:
        """Observe the plant as in the first sample."""
        self.state[:] = self.parts.backend.state
        perform(self._looking_first)

    def _check(self, fault: int) -> None:
        parts, k, rows = self.parts, self.count, self.pipeline.rows
        state = self.layout.span("position", "angular_velocity")
        before = rows[(k - 1) % len(rows), state] if k else None
        where = self.present.seen if fault == NO_LENGTH_NOMINAL else parts.backend.state
        raise Diverged(fault_message(fault, parts.robot, parts.perceived_robot, where, before, parts.control_step))
