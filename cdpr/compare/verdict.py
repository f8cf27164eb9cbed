"""One engine's run against the judge's, and against the standard that the engine must meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cdpr.compare.convergence import continuous_samples, converge
from cdpr.compare.differences import POSE, QUANTITIES, Difference, apart, difference
from cdpr.log.run import Run

Outcome = Literal["agrees", "disagrees", "failed", "not judged", "not run"]

FEWEST = 10  # samples that show how an engine converges

MOST_SPANS = 20  # that are listed


@dataclass(frozen=True)
class Check:
    """One figure that had to lie between two bounds."""

    quantity: str
    value: float
    low: float
    high: float
    time: float | None  # s
    agrees: bool


@dataclass(frozen=True)
class Span:
    """Consecutive samples in which two runs differ in kind."""

    start: float  # s
    end: float  # s, of the last sample
    samples: int


@dataclass(frozen=True)
class Verdict:
    """What came of one engine.

    Attributes:
        checks: for the standard `scheme` what the run differs by from the judge running the engine's scheme; for
            `order` the distance of the extrapolated run from the judge, root mean square.
        differences: to the judge, by quantity.
        statuses: where the solver found another status than in the run that the engine was held against.
        vertices: the same for tensions, where the solver declares that it may jump between several answers.
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
    """Judge a run by `twin`, the judge running the same scheme: they may differ by round-off.

    Without continuity tensions may stand at other vertices, and only the pose is judged.
    """
    names = list(QUANTITIES) if continuous else list(POSE)
    checks = []
    for name in names:
        bound, found = QUANTITIES[name].allowed(twin), difference(name, run, twin)
        checks.append(Check(name, found.max, 0.0, bound, found.time, found.max <= bound))
    return _verdict(run, judge, twin, checks, continuous)


def against_order(runs: Sequence[Run], judges: Sequence[Run], order: int, *, continuous: bool) -> Verdict:
    """Judge a run of an unknown scheme by its limit: extrapolated to a vanishing step it must be the judge's.

    `runs` and `judges` have the steps of `convergence.LADDER`. Where the judge's estimated error is as large as the
    engine's, nothing is judged. Tensions follow from the state, but with kinks where a cable meets a limit, of which an
    extrapolation makes anything: they are not judged.
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
    """Tell the differences alone."""
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
    """How the ends of two runs differ, "" where they do not."""
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
    """Return where `flags` (K,) holds, the first of MOST_SPANS at most."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return tuple(
        Span(float(run.time[a]), float(run.time[b - 1]), int(b - a))
        for a, b in zip(starts[:MOST_SPANS], stops[:MOST_SPANS], strict=True)
    )
