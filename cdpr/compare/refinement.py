"""The measured order: how the error falls with the physics step while the control period stays the same.

The truth is the judge at a quarter of the finest step, in the same closed loop. Where the control period is so short
that errors drown in round-off, the loop is closed less often, with all runs that belong together.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from cdpr.compare.differences import pose_apart
from cdpr.compare.engines import Engine, Field
from cdpr.compare.runs import Runs, Wanted

LADDER = (1, 2, 4)  # by which the first step is divided
TRUTH = 16  # and that of the judge, whose error is then 4^-order of its own finest one
STRETCHES = (1, 10, 20, 50)  # of the control period, in this order, until errors are above round-off
FEWEST = 10  # control periods that a run must have

# m. The finest error of three must be larger: round-off of closed loops is 1e-16 to 2e-15 m.
ABOVE_ROUND_OFF = 1e-14

# m. With a larger error than this the loop is no longer what was asked for: closed so seldom, it has become unstable.
TOO_FAR = 1e-2


@dataclass(frozen=True)
class Measured:
    """What came of one engine.

    Attributes:
        outcome: "as declared", "at round-off", "differs" or "failed".
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
    """Measure the order of the judge and of all engines whose plant is the same."""
    engines = [chosen.judge, *(each for each in chosen.engines if each.standard(chosen.judge) != "none")]
    open_, found = {engine.name: engine for engine in engines}, dict[str, Measured]()
    for base in bases(runs, solver):
        if not open_:
            break
        truth = Wanted(chosen.judge.name, solver, divide=TRUTH * base.divide, stretch=base.stretch)
        runs.make([truth, *(_rung(base, engine, divide) for engine in open_.values() for divide in LADDER)])
        above = [engine for engine in open_.values() if _promises(runs, base, truth, engine)]
        for engine in above:
            found[engine.name] = _measure(runs, base, truth, engine)
            del open_[engine.name]
    for engine in open_.values():
        found[engine.name] = _left(runs, solver, engine)
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


def _error(runs: Runs, truth: Wanted, wanted: Wanted) -> float | None:
    """Error of a run, None where it or the truth did not come to its end."""
    one, other = runs[wanted], runs[truth]
    if one.run is None or other.run is None or len(one.run.rows) != len(other.run.rows):
        return None
    return pose_apart(one.run, other.run) if one.complete and other.complete else None


def _promises(runs: Runs, base: Wanted, truth: Wanted, engine: Engine) -> bool:
    """Whether the finest of three errors should lie above round-off, judging from the first."""
    error = _error(runs, truth, _rung(base, engine, 1))
    return error is not None and error < TOO_FAR and error / LADDER[-1] ** engine.order > ABOVE_ROUND_OFF


def _measure(runs: Runs, base: Wanted, truth: Wanted, engine: Engine) -> Measured:
    rungs = [_rung(base, engine, divide) for divide in LADDER]
    errors = [_error(runs, truth, rung) for rung in rungs]
    control = runs.scenario.simulation.control_step * base.stretch
    steps = tuple(control / rung.divide for rung in rungs)
    if any(error is None or error <= 0.0 for error in errors):
        lost = next(runs[rung] for rung, error in zip(rungs, errors, strict=True) if not error)
        return Measured(engine.name, engine.order, "failed", f"{lost.status}: {lost.message}".partition("\n")[0])
    sizes: Sequence[float] = [error for error in errors if error is not None]
    order = math.log(sizes[0] / sizes[-1]) / math.log(LADDER[-1])
    outcome = "as declared" if abs(order - engine.order) <= tolerance(engine.order) else "differs"
    return Measured(engine.name, engine.order, outcome, "", order, control, steps, tuple(sizes))


def _left(runs: Runs, solver: str, engine: Engine) -> Measured:
    """An engine without three errors above round-off."""
    first = runs[_rung(next(iter(bases(runs, solver))), engine, 1)]
    if not first.complete:
        return Measured(engine.name, engine.order, "failed", f"{first.status}: {first.message}".partition("\n")[0])
    return Measured(engine.name, engine.order, "at round-off")
