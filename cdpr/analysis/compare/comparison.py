"""Comparison of several engines on one scenario: planning of the runs and verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from cdpr.analysis.compare.convergence import LADDER
from cdpr.analysis.compare.differences import QUANTITIES, difference
from cdpr.analysis.compare.engines import Engine, Field, is_continuous
from cdpr.analysis.compare.excitation import unexcited
from cdpr.analysis.compare.runs import RunResult, Runs, RunSpec
from cdpr.analysis.compare.verdict import Verdict, against_order, against_scheme, unjudged
from cdpr.log.run import Run

FAILING = ("disagrees", "failed")


@dataclass(frozen=True)
class Row:
    """One engine of a comparison; labels are unique."""

    label: str
    engine: Engine
    standard: str
    verdict: Verdict
    run: Run | None
    step_us: float | None  # wall time of a control step, for information

    def to_dict(self) -> dict[str, Any]:
        """Return a dictionary for JSON."""
        return {
            "label": self.label,
            "backend": self.engine.name,
            "order": self.engine.order,
            "scheme": self.engine.scheme,
            "standard": self.standard,
            "status": None if self.run is None else self.run.status,
            "samples": 0 if self.run is None else len(self.run.rows),
            "step_us": self.step_us,
            **self.verdict.to_dict(),
        }


@dataclass(frozen=True)
class Group:
    """All engines with one solver.

    Attributes:
        judge: run that all others are compared with; None if there is none.
        problem: reason why the judge is missing or unusable; "" otherwise.
        twins: runs of the judge with the schemes of other engines, by scheme.
        pairs: largest difference between any two engines with the same scheme, by scheme and quantity.
    """

    solver: str
    continuous: bool
    judge: Run | None
    problem: str
    rows: tuple[Row, ...]
    twins: Mapping[str, Run] = field(default_factory=dict)
    pairs: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def agrees(self) -> bool | None:
        """True if all judged engines agree; None if none could be judged."""
        outcomes = [row.verdict.outcome for row in self.rows]
        if self.problem or any(outcome in FAILING for outcome in outcomes):
            return False
        return True if "agrees" in outcomes else None

    def to_dict(self) -> dict[str, Any]:
        """Return a dictionary for JSON."""
        return {
            "solver": self.solver,
            "continuous": self.continuous,
            "problem": self.problem,
            "judge_status": None if self.judge is None else self.judge.status,
            "judge_step_us": step_cost(self.judge),
            "unexcited": [] if self.judge is None else unexcited(self.judge),
            "thinned": self.judge is not None and self.judge.header.log_every > 1,
            "judge_tension_N": None if self.judge is None else self.judge.summary().get("tension_N"),
            "agrees": self.agrees,
            "engines": [row.to_dict() for row in self.rows],
            "same_scheme": {scheme: dict(worst) for scheme, worst in self.pairs.items()},
        }


def compare(runs: Runs, chosen: Field, solvers: Sequence[str], *, named: bool) -> list[Group]:
    """Run the closed loop on the chosen engines, once with each solver, and judge the runs.

    An engine that cannot run the scenario is reported. It fails the comparison only if the user chose it by name
    (`named`).
    """
    runs.make([wanted for solver in solvers for wanted in _plan(runs, chosen, solver)])
    return [_group(runs, chosen, solver, named) for solver in solvers]


def _plan(runs: Runs, chosen: Field, solver: str) -> list[RunSpec]:
    judge = chosen.judge
    plan = [RunSpec(engine.name, solver) for engine in (judge, *chosen.engines)]
    for engine in chosen.engines:
        standard = engine.standard(judge)
        if standard == "scheme":
            plan.append(RunSpec(judge.name, solver, engine.scheme))
        elif standard == "order":
            plan += [rung for name in (engine.name, judge.name) for rung in _ladder(runs, name, solver)]
    return list(dict.fromkeys(plan))


def _ladder(runs: Runs, name: str, solver: str) -> list[RunSpec]:
    """Return the runs with the scenario's step, half and a quarter of it."""
    substeps = runs.scenario.simulation.substeps
    return [RunSpec(name, solver, divide=divide * substeps) for divide in LADDER]


def _group(runs: Runs, chosen: Field, solver: str, named: bool) -> Group:
    continuous = is_continuous(runs.scenario.with_changes(solver=solver))
    judge = runs[RunSpec(chosen.judge.name, solver)]
    if not judge.complete:
        return Group(solver, continuous, judge.run, f"the judge, {chosen.judge.name}, {judge.reason}", ())
    assert judge.run is not None
    rows = []
    for engine in chosen.engines:
        result = runs[RunSpec(engine.name, solver)]
        verdict = _judge(runs, chosen.judge, judge.run, engine, result, solver, continuous, named)
        rows.append(Row(engine.name, engine, engine.standard(chosen.judge), verdict, result.run, step_cost(result.run)))
    twins = {}
    for row in rows:
        twin = runs[RunSpec(chosen.judge.name, solver, row.engine.scheme)].run if row.standard == "scheme" else None
        if twin is not None:
            twins[row.engine.scheme] = twin
    return Group(solver, continuous, judge.run, "", tuple(rows), twins, pairs(rows))


def _judge(
    runs: Runs, judge: Engine, judged: Run, engine: Engine, one: RunResult, solver: str, continuous: bool, named: bool
) -> Verdict:
    standard = engine.standard(judge)
    if one.run is None:
        refused = one.status == "failed" and not one.begun and not named
        return Verdict("not run" if refused else "failed", one.reason)
    if standard == "none":
        return unjudged(one.run, judged, f"its plant is another one (cables: {engine.cables})")
    if standard == "scheme":
        twin = runs[RunSpec(judge.name, solver, engine.scheme)]
        if twin.run is None:
            return Verdict("failed", f"the run to judge it by {twin.reason}")
        return against_scheme(one.run, judged, twin.run, continuous=continuous)
    ladders: list[list[Run]] = []
    for name in (engine.name, judge.name):
        rungs = [runs[wanted] for wanted in _ladder(runs, name, solver)]
        if lost := next((rung for rung in rungs if rung.run is None), None):
            return Verdict("failed", f"the run to judge it by {lost.reason}")
        ladders.append([rung.run for rung in rungs if rung.run is not None])
    return against_order(ladders[0], ladders[1], engine.order, continuous=continuous)


def pairs(rows: Sequence[Row]) -> dict[str, dict[str, float]]:
    """Return the largest difference of each quantity between any two engines with the same scheme."""
    found: dict[str, dict[str, float]] = {}
    for a, b in combinations([row for row in rows if row.standard == "scheme"], 2):
        if a.engine.scheme == b.engine.scheme and a.run is not None and b.run is not None:
            worst = found.setdefault(a.engine.scheme, dict.fromkeys(QUANTITIES, 0.0))
            for name in QUANTITIES:
                worst[name] = max(worst[name], difference(name, a.run, b.run).max)
    return found


def step_cost(run: Run | None) -> float | None:
    """Return the wall time of a control step, us; None if it is unknown."""
    if run is None or len(run.rows) < 2 or not run.timings.get("loop_s"):
        return None
    return 1e6 * run.timings["loop_s"] / round(run.span[1] / run.header.control_step)
