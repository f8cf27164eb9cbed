"""The loop: state, desired, wrench, tension, one row, one step of the plant; again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from time import monotonic

import numpy as np

from cdpr.errors import BackendDied, Diverged, PluginError, SimulationStopped
from cdpr.log.recorder import BLOCK
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.plugins import Controller, TensionSolver
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.controller import Output
from cdpr.scenario.events import ScenarioEvent
from cdpr.simulation.faults import told
from cdpr.simulation.loads import Loads
from cdpr.simulation.moment import Memory, Moment
from cdpr.simulation.outside import Outside
from cdpr.simulation.pace import Pace
from cdpr.simulation.parts import Parts
from cdpr.simulation.plant import clock_acts, moving
from cdpr.simulation.playback import Playback
from cdpr.simulation.program import Program
from cdpr.simulation.record import Record
from cdpr.simulation.sample import Sample
from cdpr.simulation.schedule import Schedule
from cdpr.tension.acts import Act, perform
from cdpr.tension.command import CommandStage
from cdpr.tension.stage import Asked, TensionStage
from cdpr.tension.status import Status
from cdpr.trajectory import Trajectory

# A call of the compiled loop takes at most about so long: an interrupt waits for its end.
BRIEF = 0.02  # s

# After these a solver need not have written any tensions.
ANSWERS = (Status.OK, Status.INFEASIBLE, Status.UNSUPPORTED)


class Loop:
    """A closed loop, ready to run.

    Args:
        parts: what it is made of.
        record: keeps the commands from outside.

    Attributes:
        parts: what it is made of.
        program: its steps.
        stage: what distributes the controller's wrench, or checks its commands.
        advancing: the acts that take the plant to the next sample.
        row: the present sample, columns as `cdpr.log.layout` says; the parts work on views of it.
        out: where the controller writes: the wrench (6,) or the commands (m,).
        outside: commands that replace the answers of controller or solver.
    """

    def __init__(self, parts: Parts, record: Record | None = None) -> None:
        self.parts, self._record = parts, record or Record()
        self.last = 0
        self.present = present = Sample(parts)
        self.layout, self.row = present.layout, present.row
        self.state, self.desired = present.state, present.desired
        self.wrench, self.tension, self.W = present.live.wrench, present.live.tension, present.live.W
        # What the controller sees of them it cannot change.
        self.given_state, self.given_desired = read_only(self.state), read_only(self.desired)
        self.sample = parts.trajectory.sampler(self.desired)
        self.stage = self.stage_of(parts.output)
        self.out = self.written(self.stage)
        loads = Loads(present.view("external"), parts.backend.external)
        self.schedule = Schedule(parts.events, parts.control_step, parts.robot, self.stage, loads, parts.settings)
        self._memory = Memory(parts, present, self.stage, self.schedule)
        # What looks at the plant, and what does so at first: made once, for the geometry of pulleys takes its time.
        self._looking, self._looking_first = (present.looking(h, self._check) for h in (parts.control_step, 0.0))
        self._plan()

    @property
    def count(self) -> int:
        """How many samples are complete."""
        return self.program.count

    @property
    def time(self) -> float:
        """Of the sample that is looked at, s."""
        return self.program.time

    def warm_up(self, start: Array) -> None:
        """Call every part once and put all back to `start` (13,).

        What a first call costs, such as loading from disk, is then over before a clock runs. Raises PluginError where
        controller or solver write nothing.
        """
        parts = self.parts
        try:
            self._first()
            self.sample(0.0)
            if "controller" not in parts.live:
                self._try_control()
            self.schedule.warm_up()
            if "backend" not in parts.live:
                parts.backend.command[...] = self.tension
                parts.backend.read_tension(self.tension)
                parts.backend.step(parts.substeps)
                perform(self._looking)
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

    def _try_control(self) -> None:
        parts = self.parts
        self.out[:] = np.nan
        perform(self.program.acts[:1])
        if np.isnan(self.out).all():
            raise PluginError(
                f"the controller wrote no {parts.output}, or NaN: `control` must write into the array it is given"
            )
        self.stage.distribute()
        if self.present.live.status[0] not in ANSWERS and not self.stage.answered:
            raise PluginError(
                f"solver '{parts.solver_name}' wrote no tensions, or NaN: `solve` must write into the array it is given"
            )

    def begin(self, rows: Array, last: int) -> None:
        """Look at sample 0, at the backend's present state; from then on `decide` and `advance` make a step.

        `decide` completes sample `count`, which goes into `rows[count % len(rows)]`; `advance` takes the plant to the
        next and looks: at its state, at what happens, at what is desired. `last` is the number of the last sample;
        where there are fewer rows, their number is a multiple of 256. Both raise SimulationStopped; a sample that tells
        why there are no tensions is complete all the same.
        """
        self.write_to(rows)
        self.last = last
        self.program.place = 0, 0, 0.0, 0
        self._first()
        self.program.due = self.schedule.begin()
        self.row[0] = 0.0
        if self.program.due == 0:
            self._happen()
        self._refresh()
        self.sample(0.0)

    def revise(self, events: Sequence[ScenarioEvent], motion: Trajectory) -> None:
        """Go on with these events and the motion as they make it; what has happened is not done again."""
        self.parts = replace(self.parts, events=tuple(events), trajectory=motion)
        self.sample = motion.sampler(self.desired)
        self.schedule.plan(events)
        self._plan(self.program)

    def join(self, event: ScenarioEvent) -> None:
        """Let happen what an event, of which `revise` knows, does at the present sample, which is not yet decided."""
        self.schedule.join(event, self.count)
        self.push()
        self._refresh()
        self.sample(self.time)

    def push(self) -> None:
        """Let the external wrench of the present sample be what the events say."""
        self.program.due = self.schedule.push(self.count)

    def write_to(self, rows: Array) -> None:
        """Put the samples into `rows` from now on."""
        for program in self._programs():
            program.rows = rows

    def decide(self, given: Program | None = None) -> None:
        """Complete the sample that is looked at; by the program of a command from outside, if given."""
        if given is None and self._playback is not None:
            given = self._playback.at(self.count)
        if given is None:
            self.program.decide()
        else:
            try:
                given.decide()
            finally:
                self.program.stand()

    def advance(self) -> None:
        """Take the plant to the next sample, and look at that."""
        self.program.look(self.count)

    def run(
        self,
        rows: Array,
        flush: Callable[[int], None],
        *,
        steps: int | None = None,
        real_time: bool = False,
        block: int = BLOCK,
    ) -> int:
        """Fill `rows` (steps + 1, width) from the backend's present state; return the number of samples made.

        Fewer rows, a multiple of 256, are filled again and again, where `steps` says how many there are to make.
        `flush`, `real_time` and `block` are those of a `Pace`; `flush` may end the run by raising SimulationStopped.
        Raises that, with the time in its text, where the run stops early; `count` then tells how many samples are
        complete.
        """
        pace = Pace(flush, real_time, block)
        with self.timed():
            self.begin(rows, len(rows) - 1 if steps is None else steps)
        self.go(self.last, pace)
        with self.timed():
            self.decide()
        return self.count

    def go(self, k: int, pace: Pace, given: Program | None = None) -> None:
        """Complete the samples before sample k, and look at that; raises as `run`. `given` as for `decide`."""
        program, most = given or self.program, 1
        try:
            while (count := program.count) < k:
                if given is None and self._playback is not None:
                    self.decide()
                    self.advance()
                elif k - count == 1:
                    program.look(k)
                else:
                    start = monotonic()
                    program.look(min(k, max(pace.count, count + 1), count + most))
                    most = min(2 * most, pace.block) if monotonic() - start < BRIEF else max(most // 2, 1)
                if program.count >= pace.count or monotonic() > pace.due:
                    pace.after(program.count, program.time)
        except (SimulationStopped, PluginError) as stop:  # as `timed`, which costs as much as a step that is alone
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

    def _programs(self) -> Iterator[Program]:
        yield self.program
        yield from self.outside.programs

    def snapshot(self) -> Moment:
        """Return all that the samples after the present one depend on, to be taken between them.

        Raises PluginError where a part of the loop cannot take one.
        """
        return self._memory.take(self.program.place)

    @property
    def memory(self) -> tuple[Array, ...] | None:
        """The arrays that its steps change and need, the row first; None where there is more, such as in a part.

        What events change is not among them.
        """
        return None if self._playback is not None else self._memory.arrays

    def restore(self, snapshot: Moment) -> None:
        """Go back to a snapshot of this loop: what follows is the same to the bit. Raises PluginError likewise."""
        self._memory.put_back(snapshot)
        self.program.place = snapshot.place
        self._refresh()

    def close(self) -> None:
        """Let go of all that it is made of: its acts hold it as it holds them, and many are made one after another."""
        vars(self.program).clear()
        vars(self).clear()

    def stage_of(self, output: Output) -> TensionStage | CommandStage:
        """Make what takes the output of a controller; all share the cables."""
        parts = self.parts
        if output == "command":
            return CommandStage(parts.controlled, parts.policy, self.present.live, self.present.cables)
        solver = parts.solver
        known = isinstance(solver, TensionSolver) and speaks_for(solver.compiled, solver.solve)
        compiled = solver.compiled if known else None
        asked = Asked(solver.solve, parts.solver_name, parts.respects_bounds, parts.policy, compiled)
        return TensionStage(parts.controlled, asked, self.present.live, self.present.cables)

    def written(self, stage: TensionStage | CommandStage) -> Array:
        """What is written for a stage: commands (m,) or the wrench (6,)."""
        return stage.command if isinstance(stage, CommandStage) else self.wrench

    def through(self, stage: TensionStage | CommandStage) -> list[Act]:
        """What completes a sample, given what is written for the stage."""
        return self.present.completing(self.schedule.through(stage), self.parts.events)

    def _plan(self, before: Program | None = None) -> None:
        """Make the program of a step; it goes on where the one `before` is."""
        parts, backend, controller = self.parts, self.parts.backend, self.parts.controller
        given = self.given_state, self.given_desired, self.out
        known = isinstance(controller, Controller) and speaks_for(controller.compiled, controller.control)
        law = controller.compiled(*given) if known else None
        control = controller.control

        def ask(time: float) -> None:
            control(time, *given)

        deciding = Act("controller", law, self._refuse_code) if law else Act("controller", ask, timed=True)
        reading_clock, checking_clock = clock_acts(backend)
        self.advancing = [
            Act("command", bind("copy", source=self.tension, target=backend.command)),
            *moving(backend, parts.substeps),
            *reading_clock,
            *self._looking,
            *checking_clock,
            Act("time", bind("stamp", row=self.row), timed=True),
            Act("events", self._happen, due=True),
            Act("trajectory", self.sample, timed=True),
        ]
        checking = Act("controller", bind("not_finite", values=self.out), self._refuse_output)
        acts = [deciding, checking, *self.through(self.stage)]
        self.program = Program(acts, self.advancing, self.row, parts.control_step, before)
        self.outside = Outside(self, self._record)
        playback = Playback(parts.events, parts.control_step, self.outside.command)
        self._playback = playback if playback else None

    def _refuse_code(self, code: int) -> None:
        raise PluginError(f"the controller's compiled operation returned {code}; expected 0")

    def _refuse_output(self, _: int) -> None:
        values = ", ".join(f"{value:.4g}" for value in self.out)
        raise Diverged(f"the controller's {self.parts.output} is not finite: [{values}]; smaller gains may help")

    def _happen(self) -> None:
        """Let happen what is due at the sample that is looked at."""
        self.program.due = self.schedule.act(self.count)
        self._refresh()

    def _refresh(self) -> None:
        """Ask all acts whether they are done from now on."""
        for program in self._programs():
            program.refresh()

    def _first(self) -> None:
        self.state[:] = self.parts.backend.state
        perform(self._looking_first)

    def _check(self, fault: int) -> None:
        parts, k, rows = self.parts, self.count, self.program.rows
        state = self.layout.span("position", "angular_velocity")
        before = rows[(k - 1) % len(rows), state] if k else None
        raise Diverged(told(fault, parts.robot, parts.believed, parts.backend.state, before, parts.control_step))
