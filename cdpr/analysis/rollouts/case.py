"""One closed loop of a rollout: the scenario with the case's values, run, and reduced to the kept rows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.rollouts.figures import Figures
from cdpr.base.errors import CdprError, Diverged, ExitCode, Interrupted, one_line
from cdpr.base.problems import Mark
from cdpr.config.overrides import Change, path_of, plain_value
from cdpr.log.finite import Finite
from cdpr.log.layout import Layout
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent, broken, redirected
from cdpr.scenario.events.commands import Kind
from cdpr.simulation.build import build
from cdpr.simulation.columns import columns_of
from cdpr.simulation.loop import Loop
from cdpr.simulation.moment import Moment
from cdpr.simulation.pace import Pace
from cdpr.simulation.parts import Parts
from cdpr.simulation.pipeline import Pipeline
from cdpr.simulation.renewal import renew
from cdpr.simulation.resting_start import warm_up
from cdpr.simulation.runner import STATUS
from cdpr.simulation.step_kernel import SAMPLE

Given = tuple[Kind, Array]  # kind and values of external wrenches or commands: of one case, or a row for each

BLOCK = 1024  # samples that are processed together: few turns to Python, and they stay in the cache


def layout_of(scenario: Scenario) -> Layout:
    """Return the columns of a row of a run of this scenario."""
    return Layout(scenario.robot.m, columns_of(scenario))


def _samples(scenario: Scenario) -> tuple[object, ...]:
    """Return what the number of samples and their columns depend on."""
    simulation, m = scenario.simulation, scenario.robot.m
    return simulation.steps, simulation.control_step, m, columns_of(scenario)


@dataclass(frozen=True)
class Plan:
    """Data shared by all cases of a rollout."""

    scenario: Scenario
    keys: tuple[str, ...]  # varied keys
    every: int  # samples from one kept sample to the next
    columns: tuple[str, ...]  # kept columns

    @property
    def steps(self) -> int:
        """Return the number of control steps of a case."""
        return self.scenario.simulation.steps

    @property
    def kept(self) -> Array:
        """Return the numbers of the kept samples: one in `every` from the first on, and the last; (K,)."""
        return np.unique([*range(0, self.steps + 1, self.every), self.steps])

    @cached_property
    def layout(self) -> Layout:
        """Return the columns of a complete row."""
        return layout_of(self.scenario)

    @cached_property
    def samples(self) -> tuple[object, ...]:
        """Samples and columns of each case."""
        return _samples(self.scenario)

    @cached_property
    def places(self) -> NDArray[np.int64]:
        """Return the indices of the kept columns, (W,)."""
        none = np.zeros(0, dtype=np.int64)
        return np.concatenate([none, *(np.r_[self.layout.columns[name]] for name in self.columns)])

    @cached_property
    def tunable(self) -> bool:
        """Return True if cases differ only in options that may change between two steps."""
        started = self.scenario.initial.equilibrium  # such a start depends on the options
        return not started and not self.scenario.events and set(self.keys) <= set(self.scenario.options().changeable())

    def changed(self, number: int, values: Sequence[Any]) -> Scenario:
        """Return the scenario of a case.

        Raises:
            ScenarioError: if the scenario rejects the values.
        """
        self.scenario.planned  # noqa: B018 - once: cases with the same motion take it from there
        mark = Mark(f"case {number}")
        changes = [Change(path_of(key), plain_value(value), mark) for key, value in zip(self.keys, values, strict=True)]
        scenario = self.scenario.with_changes(changes)
        if _samples(scenario) != self.samples:
            raise CdprError(
                f"{mark}: all cases have the same samples and columns, and {', '.join(self.keys)} "
                "changed them; a study can vary that"
            )
        return scenario


class Home(Protocol):
    """Holder of the lanes of cases, a `Block`."""

    def release(self, case: Case) -> None:
        """Move a case from its lane to its own arrays."""


class Case:
    """Case of a rollout.

    Args:
        plan: data shared by all cases.
        number: number of the case.
        values: values of the varied keys.
        ring: (n, width) ring buffer of its samples; nobody else may write there while the case runs.
        out: (K, W) kept rows.
        stopped: callback that returns True if the case is to end.

    Attributes:
        loop: closed loop, once begun.
        figures: counted figures, once begun.
        pipeline: pipeline of its steps: the loop's, or one in which an external command replaces an answer.
        given: external wrench (6,) or commands (m,) that this pipeline reads; None before the first one.
        going: True if it has begun, and has not ended early.
        error: error of cdpr that ended it.
        live: events from outside that came with a loaded state.
        home: holder of the lane with its state; None while its state is in its own arrays.
        known: data of each block on it: its pipeline and the addresses of its arrays, None if it does not fit.
        joined: sample at which it took its lane.
        rest: number of samples to run alone after it left.
    """

    loop: Loop
    figures: Figures
    pipeline: Pipeline
    _place: memoryview  # as `Pipeline.standing`
    _time: memoryview

    def __init__(
        self, plan: Plan, number: int, values: Sequence[Any], ring: Array, out: Array, stopped: Callable[[], bool]
    ) -> None:
        self._plan, self._number, self._values = plan, number, values
        self._ring, self.out, self.stopped = ring, out, stopped
        self._parts: Parts | None = None
        self._ended = "finished", "", ExitCode.OK
        self._outcome: Outcome | None = None  # once its loop serves another case
        self._scenario: Scenario | None = None  # with its values
        self._start: Moment | None = None
        self.going = False
        self.error: CdprError | None = None
        self.given: Array | None = None
        self.live: tuple[ScenarioEvent, ...] = ()
        self.home: Home | None = None
        self.known: dict[Home, tuple[Pipeline, NDArray[np.int64] | None]] = {}
        self.joined = self.rest = 0

    @property
    def count(self) -> int:
        """Number of complete samples."""
        return self._place[SAMPLE]

    @property
    def time(self) -> float:
        """Present time, s."""
        return self._time[0]

    @property
    def started(self) -> bool:
        """Return True if it has a loop."""
        return hasattr(self, "loop")

    def again(self) -> Case:
        """Return the same case, not begun."""
        return Case(self._plan, self._number, self._values, self._ring, self.out, self.stopped)

    @property
    def outcome(self) -> Outcome:
        """Return status and message of its end."""
        if self._outcome is not None:
            return self._outcome
        status, message, code = self._ended
        figures = self.figures.to_dict() if hasattr(self, "figures") else {}
        return Outcome(str(self._number), status, message, "", summary=figures, code=code)

    def begin(self) -> None:
        """Observe the first sample."""
        with self._attempt():
            scenario = self._scenario = self._scenario or self._plan.changed(self._number, self._values)
            self._parts = parts = build(scenario)
            self.loop = loop = Loop(parts)
            self.pipeline = loop.pipeline
            self._place, self._time = (each.data for each in loop.pipeline.standing)
            self.figures = Figures(loop.layout, loop.row, _broken(scenario))
            loop.pipeline.release_gil()
            self._warm_up(loop)
            if self._plan.tunable and parts.settings is not None and loop.memory is not None:
                self._start = loop.snapshot()
            self.going = True

    def adopt(self, other: Case) -> bool:
        """Begin with the loop of a finished case, if only numbers differ; return whether it has begun.

        Errors in its values are left to `begin`.
        """
        plan, loop, parts, before = self._plan, other.loop, other.loop.parts, other._scenario
        assert before is not None
        try:
            if other._start is not None and all(map(_numbers, self._values)):
                assert parts.settings is not None
                options = plan.scenario.options()
                for key, value in zip(plan.keys, map(plain_value, self._values), strict=True):
                    options.change(key, value)
                loop.restore(other._start)
                parts.settings.renew(options.values)
                parts.controller.reset()
                parts.solver.reset()
                self._scenario, self._start = before, other._start
            else:
                self._scenario = scenario = plan.changed(self._number, self._values)
                if not renew(loop, before, scenario):
                    return False
                self._warm_up(loop)
        except Exception:
            return False
        other._outcome = other.outcome
        self.loop, self.pipeline, self.figures, self.known = loop, loop.pipeline, other.figures, other.known
        self._parts, self._place, self._time = other._parts, other._place, other._time
        self.figures.restart()
        other._parts, other.going = None, False
        del other.loop, other.pipeline, other.figures
        self.going = True
        return True

    def _warm_up(self, loop: Loop) -> None:
        assert self._scenario is not None
        warm_up(loop, self._scenario)
        with loop.timed():
            loop.begin(self._ring, self._plan.steps)

    def ready(self, sample: int) -> bool:
        """Return whether it can continue to this sample."""
        return self.going and self._place[SAMPLE] < sample

    def leave_block(self) -> None:
        """Move its state into its own arrays."""
        if self.home is not None:
            self.home.release(self)

    def give(self, given: Given | None) -> None:
        """Replace the answer of controller or solver from now on; None restores the controller."""
        if given is None:
            self.pipeline = self.loop.pipeline
        else:
            self.leave_block()
            kind, values = given
            command = self.loop.outside.command(kind)
            self.pipeline, self.given = command.pipeline, command.values
            self.given[:] = values

    def finish_step(self, complete: int) -> None:
        """Continue from within a step to its end; `complete` is the index of the operation that completes a sample."""
        sample, operation, _, _ = self.pipeline.place
        if operation > complete:  # the next sample is observed, and compared with this one
            self._ring[(sample - 1) % len(self._ring)] = self.loop.row
        with self._attempt():
            with self.loop.timed():
                self.pipeline.run_until(sample + (operation <= complete))
            self._take(self.loop.count)

    def go(self, sample: int) -> None:
        """Complete the samples before this one, and observe it."""
        self.leave_block()
        with self._attempt():
            self.loop.go(sample, Pace(self._take, block=BLOCK), self._replaced)
            self._take(self.loop.count)

    def finish(self) -> None:
        """Complete the remaining samples."""
        self.leave_block()
        if self.ready(self._plan.steps):
            self.go(self._plan.steps)
        if self.going:
            with self._attempt():
                with self.loop.timed():
                    self.loop.decide(self._replaced)
                self._take_last()
        if self.going and not np.isfinite(self.out).all():
            plan = self._plan
            finite = Finite(plan.layout, plan.every * plan.scenario.simulation.control_step, plan.columns)
            with self._attempt():
                finite.take(self.out, len(self.out))
                if finite.fault:
                    raise Diverged(finite.fault)

    def close(self) -> None:
        """Free its memory."""
        self.leave_block()
        if self._parts is not None:
            self._parts.controller.close()
            self._parts.backend.close()
        if self.started:
            self.loop.close()
            del self.loop
        self.going = False

    def restore(self, moment: Moment, live: tuple[ScenarioEvent, ...] = ()) -> None:
        """Continue from a snapshot of a loop of this structure, with its own events and these from outside.

        Raises:
            CdprError: if an event is impossible here; nothing is changed.
        """
        self.leave_block()
        if live != self.live:
            assert self._scenario is not None
            scenario = self._scenario
            events = (*scenario.events, *live)
            self.loop.revise(events, redirected(scenario.planned, events, scenario.simulation.control_step))
            self.pipeline, self.live = self.loop.pipeline, live
            self.known.clear()
        self.loop.restore(moment)
        self.loop.push()
        self.figures.samples = moment.count
        self._ended = "finished", "", ExitCode.OK
        self.error, self.going = None, True

    @property
    def _replaced(self) -> Pipeline | None:
        return None if self.pipeline is self.loop.pipeline else self.pipeline

    @contextmanager
    def _attempt(self) -> Iterator[None]:
        """Store an error that ends it."""
        try:
            yield
            return
        except (Interrupted, KeyboardInterrupt):
            raise
        except CdprError as error:
            self._ended, self.error = (STATUS.get(type(error), "failed"), str(error), error.exit_code), error
        except BaseException as error:  # of a plugin
            self._ended = "failed", f"a plugin raised {one_line(error)}", ExitCode.PLUGIN
        if self.going:
            self.going = False
            self._take(self.loop.count)

    def _take_last(self) -> None:
        """Take the last sample, which is still the present one."""
        self.figures.counting()
        self.figures.samples += 1
        if len(self.out):
            self.out[-1] = self.loop.row[self._plan.places]
        if self.stopped():
            raise Interrupted("the rollout was stopped")

    def _take(self, stop: int) -> None:
        """Take the samples up to `stop`, excluded, which are consecutive in the ring buffer."""
        done = self.figures.samples
        if stop > done:
            first = done % len(self._ring)
            rows = self._ring[first : first + stop - done]
            self.figures.take(rows, self._plan.places, max(self._plan.every, 1), self.out)
        if self.stopped():
            raise Interrupted("the rollout was stopped")


def _broken(scenario: Scenario) -> tuple[tuple[int, float], ...]:
    names = [cable.name for cable in scenario.robot.cables]
    return broken(scenario.events, names, scenario.simulation.control_step)


def _numbers(value: Any) -> bool:
    """Return whether a value is a number, or consists of numbers."""
    found = plain_value(value)
    each = found if isinstance(found, list) else [found]
    return all(isinstance(one, int | float) and not isinstance(one, bool) for one in each)
