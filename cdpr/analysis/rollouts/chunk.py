"""Chunk of cases, run one after the other or eight at a time: the unit of work of a thread or a worker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.rollouts.case import BLOCK, Case, Plan
from cdpr.analysis.rollouts.group import Group
from cdpr.model.robot import Array
from cdpr.native.operations import LANES


@dataclass(frozen=True)
class Chunk:
    """Consecutive cases of a rollout."""

    plan: Plan
    numbers: tuple[int, ...]
    values: tuple[tuple[Any, ...], ...]  # of the keys, for each case


def run_chunk(chunk: Chunk, stopped: Callable[[], bool] = lambda: False) -> tuple[list[Outcome], Array]:
    """Run cases; return the end of each one and its rows, (n, K, W), NaN after its end.

    Raises:
        Interrupted: once `stopped`.
    """
    plan = chunk.plan
    rows = np.full((len(chunk.numbers), len(plan.kept), len(plan.places)), np.nan)
    ring = np.empty((min(plan.steps + 1, BLOCK), plan.layout.width))
    cases = [
        Case(plan, number, values, ring, out, stopped)
        for number, values, out in zip(chunk.numbers, chunk.values, rows, strict=True)
    ]
    group = Group(plan)
    ended: list[Case] = []  # finished cases, with loops for the next ones
    try:
        for first in range(0, len(cases), LANES):
            under_way = cases[first : first + LANES]
            for case in under_way:
                other = ended.pop(0) if ended else None
                if other is None or not case.adopt(other):
                    if other is not None:
                        other.close()
                    case.begin()
            group.go(under_way, [plan.steps] * len(under_way))
            for case in under_way:
                case.finish()
                if case.going:
                    ended.append(case)
                else:
                    case.close()
        return [case.outcome for case in cases], rows
    finally:
        for case in cases:
            case.close()
