"""The measured order: how the error falls with the physics step while the control period stays the same.

The truth is the judge's scheme of highest order at a quarter of the finest step, in the same closed loop. Where the
control period is so short that errors drown in round-off, the loop is closed less often, with all runs that belong
together.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from cdpr.compare.differences import pose_apart, size
from cdpr.compare.engines import Engine, Field, finest_scheme
from cdpr.compare.runs import Made, Runs, Wanted

LADDER = (1, 2, 4)  # by which the first step is divided
TRUTH = 16  # and that of the truth: of order four its error is 0.4 % of the finest one of a run of that order
STRETCHES = (1, 10, 20, 50)  # of the control period, in this order, until errors are above round-off
FEWEST = 10  # control periods that a run must have

# As a share of the robot's size, as `differences.size` has it. The finest error of three must be larger: round-off of
# closed loops is 2e-17 to 4e-16 of it.
ABOVE_ROUND_OFF = 2e-15

# With a larger error than this share no power of the step is to be seen: the step is too long, or the loop, closed so
# seldom, has become unstable.
TOO_FAR = 2e-3


@dataclass(frozen=True)
class Measured:
    """What came of one engine.

    Attributes:
        outcome: "as declared", "at round-off", "differs", "too far" or "failed".
        reason: why the order is not as declared or could not be measured.
        order: measured, None unless there are three errors above round-off.
        steps: physics steps, s.
        errors: root mean square of the distance in pose from the truth, m, angles times the characteristic length.
    """

    backend: str
    declared: int
    outcome: str
    reason: str = ""
    order: float | None = None
    control_step: float | None = None
    steps: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return a dictionary for JSON."""
        return asdict(self)

    @property
    def agrees(self) -> bool:
        """Whether nothing speaks against the declared order."""
        return self.outcome in ("as declared", "at round-off")


def tolerance(order: int) -> float:
    """Of a measured order: errors follow a power of the step only as that goes to zero."""
    return max(0.1, 0.075 * order)


def refine(runs: Runs, chosen: Field, solver: str) -> list[Measured]:
    """Measure the order of the judge and of all engines whose plant is the same; of those that ran the scenario."""
    engines = [chosen.judge, *(each for each in chosen.engines if each.standard(chosen.judge) != "none")]
    runs.make([Wanted(engine.name, solver) for engine in engines])
    engines = [engine for engine in engines if runs[Wanted(engine.name, solver)].run is not None]
    if chosen.judge not in engines:
        return []
    scheme = finest_scheme(runs.scenario, chosen.judge)
    found: dict[str, Measured] = {}
    open_ = list(engines)
    for base in bases(runs, solver):
        if not open_:
            break
        finest = Wanted(chosen.judge.name, solver, scheme, TRUTH * base.divide, base.stretch)
        runs.make([finest, *(_rung(base, engine, divide) for engine in open_ for divide in LADDER)])
        truth = runs[finest]
        for engine in tuple(open_):
            hindrance = _hindrance(runs, base, truth, engine)
            if hindrance is None:
                found[engine.name] = _measure(runs, base, truth, engine)
                open_.remove(engine)
            elif engine.name not in found or hindrance.outcome == "at round-off":
                found[engine.name] = hindrance
    return [found[engine.name] for engine in engines]


def bases(runs: Runs, solver: str) -> Iterator[Wanted]:
    """First steps to try: the scenario's, then the control period in one, then longer and longer periods."""
    simulation = runs.scenario.simulation
    divides = dict.fromkeys((simulation.substeps, 1))
    for divide in divides:
        yield Wanted("", solver, divide=divide)
    for stretch in STRETCHES[1:]:
        if simulation.steps // stretch >= FEWEST:
            yield Wanted("", solver, divide=1, stretch=stretch)


def _rung(base: Wanted, engine: Engine, divide: int) -> Wanted:
    return Wanted(engine.name, base.solver, divide=base.divide * divide, stretch=base.stretch)


def _error(one: Made, truth: Made) -> float | str:
    """Error of a run, or why there is none."""
    if truth.run is None or not truth.complete:
        return f"the truth {truth.reason}"
    if one.run is None or not one.complete:
        return one.reason
    if len(one.run.rows) != len(truth.run.rows):
        return f"it ended at {one.run.time[-1]:.6g} s, the truth at {truth.run.time[-1]:.6g} s"
    return pose_apart(one.run, truth.run)


def _hindrance(runs: Runs, base: Wanted, truth: Made, engine: Engine) -> Measured | None:
    """Why three errors between round-off and TOO_FAR are not to be expected, judging from the first."""
    error = _error(runs[_rung(base, engine, 1)], truth)
    if isinstance(error, str):
        return Measured(engine.name, engine.order, "failed", error)
    assert truth.run is not None
    scale = size(truth.run)
    if not error < TOO_FAR * scale:
        step = 1e3 * runs.scenario.simulation.control_step * base.stretch / base.divide
        reason = f"{error:.2g} m from the truth with a step of {step:g} ms: choose a shorter simulation.physics_step"
        return Measured(engine.name, engine.order, "too far", reason)
    if error / LADDER[-1] ** engine.order <= ABOVE_ROUND_OFF * scale:
        return Measured(engine.name, engine.order, "at round-off")
    return None


def _measure(runs: Runs, base: Wanted, truth: Made, engine: Engine) -> Measured:
    rungs = [_rung(base, engine, divide) for divide in LADDER]
    control = runs.scenario.simulation.control_step * base.stretch
    steps = tuple(control / rung.divide for rung in rungs)
    errors: list[float] = []
    for rung in rungs:
        error = _error(runs[rung], truth)
        if isinstance(error, str):
            return Measured(engine.name, engine.order, "failed", error)
        errors.append(error)
    order = math.log(errors[0] / errors[-1]) / math.log(LADDER[-1]) if errors[-1] > 0.0 else math.inf
    sound = abs(order - engine.order) <= tolerance(engine.order)
    reason = "" if sound else f"of order {order:.3g}, declared {engine.order}"
    outcome = "as declared" if sound else "differs"
    return Measured(engine.name, engine.order, outcome, reason, order, control, steps, tuple(errors))
