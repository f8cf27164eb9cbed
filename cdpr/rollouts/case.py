"""One closed loop of a rollout: the scenario with the case's values, run, and thinned into the rows that are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cdpr.errors import CdprError, ExitCode, Interrupted, one_line
from cdpr.jobs.cases import Outcome
from cdpr.log.layout import Layout
from cdpr.model.robot import Array
from cdpr.problems import Mark
from cdpr.rollouts.figures import Figures
from cdpr.scenario import Scenario
from cdpr.scenario.events import broken
from cdpr.scenario.overrides import PART, Change, plain_value
from cdpr.simulation.attempt import STATUS
from cdpr.simulation.build import build
from cdpr.simulation.columns import columns_of
from cdpr.simulation.loop import Loop

BLOCK = 1024  # samples of a case that are looked at together: few turns to Python, and they stay in the cache


def layout_of(scenario: Scenario) -> Layout:
    """Columns of a row of a run of this scenario."""
    return Layout(scenario.robot.m, scenario.ideal_cables, columns_of(scenario))


@dataclass(frozen=True)
class Plan:
    """What all cases of a rollout share."""

    scenario: Scenario
    keys: tuple[str, ...]  # that are varied
    every: int  # samples from one that is kept to the next
    columns: tuple[str, ...]  # that are kept

    @property
    def steps(self) -> int:
        """Control steps of a case."""
        return self.scenario.simulation.steps

    @property
    def kept(self) -> Array:
        """Numbers of the samples that are kept: every so manyth from the first on, and the last; (K,)."""
        return np.unique([*range(0, self.steps + 1, self.every), self.steps])

    @cached_property
    def layout(self) -> Layout:
        """Columns of a row of which some are kept."""
        return layout_of(self.scenario)

    @cached_property
    def places(self) -> Array:
        """Columns of a row that are kept, (W,)."""
        return np.concatenate([np.r_[self.layout.columns[name]] for name in self.columns])

    def changed(self, number: int, values: Sequence[Any]) -> Scenario:
        """Return the scenario of a case; ScenarioError where it does not take the values."""
        self.scenario.planned  # noqa: B018 - once: cases with the same motion take it from there
        mark = Mark(f"case {number}")
        changes = [
            Change(tuple(int(index) if index else word for index, word in PART.findall(key)), plain_value(value), mark)
            for key, value in zip(self.keys, values, strict=True)
        ]
        scenario = self.scenario.with_changes(changes)
        if (scenario.simulation.steps, scenario.simulation.control_step, layout_of(scenario)) != (
            self.steps,
            self.scenario.simulation.control_step,
            self.layout,
        ):
            raise CdprError(
                f"{mark}: all cases of a rollout have the same samples and columns, and {', '.join(self.keys)} "
                "changed them; a study can vary that"
            )
        return scenario


@dataclass(frozen=True)
class Chunk:
    """Some cases, one after the other: what a thread or a cluster's worker is given at a time."""

    plan: Plan
    numbers: tuple[int, ...]
    values: tuple[tuple[Any, ...], ...]  # of the keys, for each case


def run_chunk(chunk: Chunk, stopped: Callable[[], bool] = lambda: False) -> tuple[list[Outcome], Array]:
    """Run cases; return how each ended and its rows, (n, K, W), NaN after its end.

    Raises Interrupted once `stopped`.
    """
    plan = chunk.plan
    rows = np.full((len(chunk.numbers), len(plan.kept), len(plan.places)), np.nan)
    ring = np.empty((min(plan.steps + 1, BLOCK), plan.layout.width))
    outcomes = [
        run_case(plan, number, values, ring, out, stopped)
        for number, values, out in zip(chunk.numbers, chunk.values, rows, strict=True)
    ]
    return outcomes, rows


def run_case(
    plan: Plan, number: int, values: Sequence[Any], ring: Array, out: Array, stopped: Callable[[], bool]
) -> Outcome:
    """Run one case with the samples in `ring` (n, width), again and again, and those that are kept in `out` (K, W)."""
    keeper: _Keeper | None = None
    status, message, code = "finished", "", ExitCode.OK
    try:
        scenario = plan.changed(number, values)
        parts = build(scenario)
        try:
            loop = Loop(parts)
            keeper = _Keeper(plan, ring, out, Figures(loop.layout, _broken(scenario)), stopped)
            loop.program.apart()
            loop.warm_up(scenario.initial.state())
            try:
                loop.run(ring, keeper.take, steps=plan.steps, block=BLOCK)
            finally:
                keeper.take(loop.count)
        finally:
            parts.controller.close()
            parts.backend.close()
    except Interrupted:
        raise
    except CdprError as error:
        status, message, code = STATUS.get(type(error), "failed"), str(error), error.exit_code
    except Exception as error:  # of a plugin
        status, message, code = "failed", f"a plugin raised {one_line(error)}", ExitCode.PLUGIN
    figures = {} if keeper is None else keeper.figures.told()
    return Outcome(str(number), status, message, "", summary=figures, code=code)


def _broken(scenario: Scenario) -> tuple[tuple[int, float], ...]:
    names = [cable.name for cable in scenario.robot.cables]
    return broken(scenario.events, names, scenario.simulation.control_step)


class _Keeper:
    """Takes from the ring of samples what is kept, and counts all."""

    def __init__(self, plan: Plan, ring: Array, out: Array, figures: Figures, stopped: Callable[[], bool]) -> None:
        self.figures = figures
        self._plan, self._ring, self._out, self._stopped = plan, ring, out, stopped

    def take(self, stop: int) -> None:
        """Take the samples up to `stop`, excluded: all of them follow one another in the ring."""
        plan, ring, done = self._plan, self._ring, self.figures.samples
        if stop > done:
            first = done % len(ring)
            rows = ring[first : first + stop - done]
            self.figures.add(rows)
            skip = -done % plan.every
            kept = rows[skip :: plan.every]
            at = (done + skip) // plan.every
            self._out[at : at + len(kept)] = kept[:, plan.places]
            if stop == plan.steps + 1:
                self._out[-1] = rows[-1, plan.places]
        if self._stopped():
            raise Interrupted("the rollout was stopped")
