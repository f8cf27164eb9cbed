"""Some cases of a rollout, one after the other or eight at a time: what a thread or a worker is given at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.jobs.cases import Outcome
from cdpr.model.robot import Array
from cdpr.native.operations import LANES
from cdpr.rollouts.case import BLOCK, Case, Plan
from cdpr.rollouts.eights import Eights
from cdpr.rollouts.recipe import UnfitError


@dataclass(frozen=True)
class Chunk:
    """Some cases."""

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
    cases = [
        Case(plan, number, values, ring, out, stopped)
        for number, values, out in zip(chunk.numbers, chunk.values, rows, strict=True)
    ]
    eights: Eights | None = None
    for first in range(0, len(cases), LANES):
        eights = _run(plan, cases[first : first + LANES], eights)
    return [case.outcome for case in cases], rows


def _run(plan: Plan, cases: Sequence[Case], eights: Eights | None) -> Eights | None:
    """Run up to eight cases; return what went on with them side by side."""
    try:
        for case in cases:
            case.begin()
        going = [case for case in cases if case.going]
        try:
            eights = eights or (Eights(plan, going[0]) if going else None)
            if eights is not None:
                eights.run(going)
        except UnfitError:
            pass
        for case in cases:
            case.finish()
    finally:
        for case in cases:
            case.close()
    return eights
