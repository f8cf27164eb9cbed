"""Verdict on the run of one engine, by the judge's run and the standard that applies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.compare.convergence import continuous_samples, converge
from cdpr.analysis.compare.differences import POSE, QUANTITIES, Difference, apart, difference
from cdpr.log.run import Run

Outcome = Literal["agrees", "disagrees", "failed", "not judged", "not run"]

FEWEST = 10  # samples required to judge convergence

MOST_SPANS = 20  # maximum number of listed spans


@dataclass(frozen=True)
class Check:
    """One figure with its required range."""

    quantity: str
    value: float
    low: float
    high: float
    time: float | None  # s
    agrees: bool


@dataclass(frozen=True)
class Span:
    """Consecutive samples at which two runs differ."""

    start: float  # s
    end: float  # s, time of the last sample
    samples: int


@dataclass(frozen=True)
class Verdict:
    """Verdict on one engine.

    Attributes:
        checks: for the standard `scheme`, differences from the judge with the engine's scheme; for `order`, root mean
            square distance of the extrapolated run from the judge.
        differences: differences from the judge by quantity.
        statuses: spans with another solver status than in the reference run.
        vertices: spans with other tensions, if the solver does not declare continuity.
    """

    outcome: Outcome
    reason: str = ""
    differences: dict[str, Difference] | None = None
    checks: tuple[Check, ...] = ()
    statuses: tuple[Span, ...] = ()
    vertices: tuple[Span, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return a dictionary for JSON."""
        return asdict(self)


def against_scheme(run: Run, judge: Run, twin: Run, *, continuous: bool) -> Verdict:
    """Judge a run by `twin`, the judge's run with the same scheme; they may differ only by round-off.

    Without continuity, tensions may lie at other vertices, and only the pose is judged.
    """
    names = list(QUANTITIES) if continuous else list(POSE)
    checks = []
    for name in names:
        bound, found = QUANTITIES[name].allowed(twin), difference(name, run, twin)
        checks.append(Check(name, found.max, 0.0, bound, found.time, found.max <= bound))
    return _verdict(run, judge, twin, checks, continuous)


def against_order(runs: Sequence[Run], judges: Sequence[Run], order: int, *, continuous: bool) -> Verdict:
    """Judge a run of a unique scheme by its extrapolation to a vanishing step, which must equal the judge's.

    `runs` and `judges` have the steps of `convergence.LADDER`. There is no verdict if the judge's estimated error is as
    large as the engine's. Tensions are not judged: they have kinks where a cable reaches a limit, which make the
    extrapolation unreliable.
    """
    names = [name for name in QUANTITIES if name != "tension"] if continuous else list(POSE)
    checks, slow, blind = [], "", []
    count = continuous_samples([*runs, *judges])
    if count < min(FEWEST, *(len(run.rows) for run in (*runs, *judges))):
        reason = f"the solver fails at {runs[0].time[count]:.6g} s, after which tensions may jump"
        return unjudged(runs[0], judges[0], reason)
    for name in names:
        found = converge(name, runs, judges, order, count)
        checks.append(Check(name, found.limit, 0.0, found.allowed, None, found.agrees))
        if name not in POSE or found.errors[0] <= QUANTITIES[name].allowed(judges[-1]):
            continue
        blind.append(found.blind)
        if found.lacks(order):
            first, second = found.orders
            slow = (
                f"{QUANTITIES[name].title} converges with order {first:.2g} and {second:.2g} as the step is halved, "
                f"declared is {order}"
            )
    verdict = _verdict(runs[0], judges[0], judges[0], checks, continuous, others=tuple(zip(runs, judges, strict=True)))
    if verdict.outcome == "agrees" and slow:
        return replace(verdict, outcome="disagrees", reason=slow)
    if verdict.outcome == "agrees" and blind and all(blind):
        reason = f"the estimated error of {judges[-1].header.backend} is as large as the difference"
        return replace(verdict, outcome="not judged", reason=reason)
    return verdict


def unjudged(run: Run, judge: Run, reason: str) -> Verdict:
    """Return the differences without a verdict."""
    return Verdict("not judged", reason, _differences(run, judge), statuses=spans(run, _other_status(run, judge)))


def _verdict(
    run: Run,
    judge: Run,
    standard: Run,
    checks: Sequence[Check],
    continuous: bool,
    others: Sequence[tuple[Run, Run]] = (),
) -> Verdict:
    reasons = [_ending(a, b) for a, b in ((run, standard), *others)]
    reasons += [f"{QUANTITIES[check.quantity].title} beyond its bound" for check in checks if not check.agrees]
    reason = next((text for text in reasons if text), "")
    return Verdict(
        "disagrees" if reason else "agrees",
        reason,
        _differences(run, judge),
        tuple(checks),
        spans(run, _other_status(run, standard)),
        () if continuous else spans(run, apart("tension", run, standard)[1] > QUANTITIES["tension"].allowed(standard)),
    )


def _ending(run: Run, standard: Run) -> str:
    """Return the difference between the ends of two runs; "" if there is none."""
    if run.status != standard.status:
        return f"the run {_ended(run)}, {standard.header.backend} {_ended(standard)}"
    if len(run.rows) != len(standard.rows):
        return f"the run ended at {_last(run):.6g} s, {standard.header.backend} at {_last(standard):.6g} s"
    return ""


def _ended(run: Run) -> str:
    return "finished" if run.status == "finished" else f"ended as {run.status} at {_last(run):.6g} s"


def _last(run: Run) -> float:
    return float(run.time[-1]) if len(run.rows) else 0.0


def _differences(run: Run, judge: Run) -> dict[str, Difference]:
    return {name: difference(name, run, judge) for name in QUANTITIES}


def _other_status(a: Run, b: Run) -> NDArray[np.bool_]:
    count = min(len(a.rows), len(b.rows))
    return np.asarray(a.solver_status[:count] != b.solver_status[:count])


def spans(run: Run, flags: NDArray[np.bool_]) -> tuple[Span, ...]:
    """Return the spans in which `flags` (K,) is True, at most MOST_SPANS."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return tuple(
        Span(float(run.time[a]), float(run.time[b - 1]), int(b - a))
        for a, b in zip(starts[:MOST_SPANS], stops[:MOST_SPANS], strict=True)
    )
