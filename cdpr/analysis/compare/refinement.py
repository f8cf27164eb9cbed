"""Measured order of convergence with the physics step, at a constant control period.

The order is reported, with the reason if it is not as declared, but does not affect verdicts: correct schemes miss
their order at kinks, with long steps and at round-off. Engines are judged by their errors; see `verdict`.

The reference ("truth") is the same closed loop with the judge's scheme of the highest order at a quarter of the finest
step. If the control period is so short that errors vanish in round-off, all runs are repeated with a longer control
period.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from cdpr.analysis.compare.convergence import LADDER, local_order
from cdpr.analysis.compare.differences import pose_apart, size
from cdpr.analysis.compare.engines import Engine, Field, finest_scheme
from cdpr.analysis.compare.runs import RunResult, Runs, RunSpec
from cdpr.log.run import Run

TRUTH = 16  # divisor of the reference; at order four its error is 0.4 % of that of the finest run
STRETCHES = (1, 10, 20, 50)  # factors of the control period, tried in this order until errors exceed round-off
FEWEST = 10  # control periods that a run needs

# Share of the robot's size (`differences.size`) that the finest of three errors must exceed: round-off of closed loops
# is 2e-17 to 4e-16 of it.
ABOVE_ROUND_OFF = 2e-15

# Errors above this share follow no power of the step: the step is too long, or the loop with its long control period is
# unstable.
TOO_FAR = 2e-3

# Below this share, round-off is a hundredth or more of the finest error and changes the order.
NEAR_ROUND_OFF = 100 * ABOVE_ROUND_OFF


@dataclass(frozen=True)
class Measured:
    """Measured order of one engine.

    Attributes:
        outcome: "as declared"; or the reason of a different order: "at round-off", "kinks", "long steps", "too far",
            "unlike" (unexplained); or "failed".
        reason: the reason as a sentence; "" if the order is as declared.
        order: measured order; None without three errors above round-off.
        steps: physics steps, s.
        errors: root mean square distance in pose from the reference, m; angles times the characteristic length.
        truth_error: upper estimate of the reference's error, m.
    """

    backend: str
    declared: int
    outcome: str
    reason: str = ""
    order: float | None = None
    control_step: float | None = None
    steps: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()
    truth_error: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return a dictionary for JSON."""
        return asdict(self)

    @property
    def failed(self) -> bool:
        """True if a run did not finish for reasons other than the step."""
        return self.outcome == "failed"


def tolerance(order: int) -> float:
    """Return the tolerance of a measured order; errors follow a power of the step only in the limit."""
    return max(0.1, 0.075 * order)


def refine(runs: Runs, chosen: Field, solver: str) -> list[Measured]:
    """Measure the orders of the judge and of all engines with the same plant that ran the scenario."""
    engines = [chosen.judge, *(each for each in chosen.engines if each.standard(chosen.judge) != "none")]
    runs.make([RunSpec(engine.name, solver) for engine in engines])
    engines = [engine for engine in engines if runs[RunSpec(engine.name, solver)].run is not None]
    if chosen.judge not in engines:
        return []
    scheme = finest_scheme(runs.scenario, chosen.judge)
    found: dict[str, Measured] = {}
    open_ = list(engines)
    for base in bases(runs, solver):
        if not open_:
            break
        finest = RunSpec(chosen.judge.name, solver, scheme, TRUTH * base.divide, base.stretch)
        coarser = replace(finest, divide=LADDER[-1] * base.divide)
        runs.make([finest, coarser, *(_rung(base, engine, divide) for engine in open_ for divide in LADDER)])
        truth = runs[finest]
        for engine in tuple(open_):
            hindrance = _hindrance(runs, base, truth, engine)
            if hindrance is None:
                found[engine.name] = _measure(runs, base, truth, runs[coarser], engine)
                open_.remove(engine)
            elif engine.name not in found or hindrance.outcome == "at round-off":
                found[engine.name] = hindrance
    return [found[engine.name] for engine in engines]


def bases(runs: Runs, solver: str) -> Iterator[RunSpec]:
    """Yield the first steps to try: the scenario's, then the control period, then longer and longer periods."""
    simulation = runs.scenario.simulation
    divides = dict.fromkeys((simulation.substeps, 1))
    for divide in divides:
        yield RunSpec("", solver, divide=divide)
    for stretch in STRETCHES[1:]:
        if simulation.steps // stretch >= FEWEST:
            yield RunSpec("", solver, divide=1, stretch=stretch)


def _rung(base: RunSpec, engine: Engine, divide: int) -> RunSpec:
    return RunSpec(engine.name, base.solver, divide=base.divide * divide, stretch=base.stretch)


def _error(one: RunResult, truth: RunResult) -> float | str:
    """Return the error of a run, or the reason why there is none."""
    if truth.run is None or not truth.complete:
        return f"the truth {truth.reason}"
    if one.run is None or not one.complete:
        return one.reason
    if len(one.run.rows) != len(truth.run.rows):
        return f"it ended at {one.run.time[-1]:.6g} s, the truth at {truth.run.time[-1]:.6g} s"
    return pose_apart(one.run, truth.run)


def _lost(one: RunResult, truth: RunResult) -> str:
    """Return the outcome of a run without an error: "failed" if it is missing, "too far" if it ended early."""
    return "failed" if one.run is None or truth.run is None else "too far"


def _hindrance(runs: Runs, base: RunSpec, truth: RunResult, engine: Engine) -> Measured | None:
    """Return why three errors between round-off and TOO_FAR are not expected from the first; None if they are."""
    one = runs[_rung(base, engine, 1)]
    error = _error(one, truth)
    if isinstance(error, str):
        return Measured(engine.name, engine.order, _lost(one, truth), error)
    assert truth.run is not None
    scale = size(truth.run)
    if not error < TOO_FAR * scale:
        step = 1e3 * runs.scenario.simulation.control_step * base.stretch / base.divide
        reason = f"{error:.2g} m from the truth with a step of {step:g} ms: choose a shorter simulation.physics_step"
        return Measured(engine.name, engine.order, "too far", reason)
    if error / LADDER[-1] ** engine.order <= ABOVE_ROUND_OFF * scale:
        return Measured(engine.name, engine.order, "at round-off")
    return None


def _measure(runs: Runs, base: RunSpec, truth: RunResult, coarser: RunResult, engine: Engine) -> Measured:
    rungs = [_rung(base, engine, divide) for divide in LADDER]
    control = runs.scenario.simulation.control_step * base.stretch
    steps = tuple(control / rung.divide for rung in rungs)
    errors: list[float] = []
    for rung in rungs:
        one = runs[rung]
        error = _error(one, truth)
        if isinstance(error, str):
            return Measured(engine.name, engine.order, _lost(one, truth), error)
        errors.append(error)
    order = local_order(errors[0], errors[-1]) / math.log2(LADDER[-1])
    outcome, reason = _explain(engine.order, order, errors, truth)
    apart = _error(coarser, truth)
    # At order 1 or higher, the reference is at most a quarter as far from the solution as the coarser run.
    truth_error = None if isinstance(apart, str) else apart / 3.0
    return Measured(engine.name, engine.order, outcome, reason, order, control, steps, tuple(errors), truth_error)


def _explain(declared: int, order: float, errors: Sequence[float], truth: RunResult) -> tuple[str, str]:
    """Return the outcome and the reason of a measured order."""
    if abs(order - declared) <= tolerance(declared):
        return "as declared", ""
    assert truth.run is not None
    what = f"order {order:.3g} instead of {declared}"
    if order < declared and errors[-1] <= NEAR_ROUND_OFF * size(truth.run):
        return "at round-off", f"{what}: the finest error, {errors[-1]:.1e} m, is near round-off"
    if kink := _kink(truth.run):
        return "kinks", f"{what}: {kink}; no scheme reaches a high order at such kinks"
    first, second = local_order(*errors[:2]), local_order(*errors[1:])
    if abs(first - second) > 0.5 * tolerance(declared):
        return "long steps", (
            f"{what}: it changes from {first:.3g} to {second:.3g} when the step is halved; choose a shorter "
            "simulation.physics_step to see the order"
        )
    return "unlike", f"{what}; kinks, long steps or round-off do not explain it: check the declared order"


def _kink(run: Run) -> str:
    """Return the cause of abrupt force changes in a run; "" if none is found."""
    slack = np.asarray(run.cable_tension <= 0.0)
    if (slack.any(axis=0) & ~slack.all(axis=0)).any():
        first = int(np.argmax((slack != slack[0]).any(axis=1)))
        cable = run.header.cables[int(np.argmax(slack[first] != slack[0]))]
        how = "goes slack" if slack[first, run.header.cables.index(cable)] else "becomes taut"
        return f"cable '{cable}' {how} at {run.time[first]:.4g} s"
    changed = run.at_limit != run.at_limit[0]
    if changed.any():
        return f"a cable reaches or leaves a tension limit at {run.time[int(np.argmax(changed))]:.4g} s"
    return ""
