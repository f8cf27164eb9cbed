"""Some cases of a rollout, one after the other or eight at a time: what a thread or a worker is given at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.jobs.cases import Outcome
from cdpr.model.robot import Array
from cdpr.native.operations import LANES
from cdpr.rollouts.block import Group
from cdpr.rollouts.case import BLOCK, Case, Plan


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
    group = Group(plan)
    for first in range(0, len(cases), LANES):
        _run(plan, cases[first : first + LANES], group)
    return [case.outcome for case in cases], rows


def _run(plan: Plan, cases: Sequence[Case], group: Group) -> None:
    """Run up to eight cases."""
    try:
        for case in cases:
            case.begin()
        group.go(cases, [plan.steps] * len(cases))
        for case in cases:
            case.finish()
    finally:
        for case in cases:
            case.close()
