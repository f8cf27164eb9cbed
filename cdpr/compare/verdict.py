"""One engine's run against the judge's, and against the standard that the engine must meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cdpr.compare.differences import POSE, QUANTITIES, Difference, apart, difference
from cdpr.log.run import Run

Outcome = Literal["agrees", "disagrees", "failed", "not judged", "not run"]

# Of a ratio that is a power of two: errors are in proportion to step^order only as the step goes to zero.
RATIO_TOLERANCE = 0.1

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
            `order` by what half the step divides the distance to the judge.
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


def against_order(run: Run, judge: Run, halved: Run, halved_judge: Run, order: int, *, continuous: bool) -> Verdict:
    """Judge a run of an unknown scheme by another with half the step: the distance to the judge is to shrink."""
    names = list(QUANTITIES) if continuous else list(POSE)
    checks = []
    for name in names:
        found, left = difference(name, run, judge), difference(name, halved, halved_judge)
        bound = QUANTITIES[name].allowed(judge)
        if found.max <= bound:
            checks.append(Check(name, found.max, 0.0, bound, found.time, True))
            continue
        ratio = found.rms / left.rms if left.rms > 0.0 else np.inf
        low, high = (1 - RATIO_TOLERANCE) * 2**order, (1 + RATIO_TOLERANCE) * 2**order
        checks.append(Check(name, ratio, low, high, None, low <= ratio <= high))
    return _verdict(run, judge, judge, checks, continuous, other=(halved, halved_judge))


def unjudged(run: Run, judge: Run, reason: str) -> Verdict:
    """Tell the differences alone."""
    return Verdict("not judged", reason, _differences(run, judge), statuses=spans(run, _other_status(run, judge)))


def _verdict(
    run: Run,
    judge: Run,
    standard: Run,
    checks: Sequence[Check],
    continuous: bool,
    other: tuple[Run, Run] | None = None,
) -> Verdict:
    reasons = [_ending(a, b) for a, b in ((run, standard), *([other] if other else []))]
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
