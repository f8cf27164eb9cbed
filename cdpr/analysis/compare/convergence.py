"""Convergence of an engine to the judge's solution as the physics step shrinks.

An engine with a scheme of its own cannot be compared at one step, but its solution for a vanishing step can. That
solution is extrapolated from runs with three steps. It must equal the judge's within the errors of the extrapolation
and of the judge. The measured order is no such bound: at kinks (slack cables, friction) and with long steps, correct
schemes do not reach their order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.analysis.compare.differences import QUANTITIES, head
from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.tension.status import OK

LADDER = (1, 2, 4)  # divisors of the first step

# The two extrapolations from three steps differ by more than the error of the better one: by three times for order 1 in
# a smooth loop. Kinks between two samples can make a single difference small by chance, so twice the difference is
# allowed.
SPREADS = 2.0

# Share of the finest run's error that the extrapolation may miss. Each further halving divides the finest error by at
# least 2; three steps can show a fault of a fiftieth of it.
SHARE = 0.02

# The judge's own error is at most the distance between its two finest runs (a third of it for order 2, less for order
# 4, about all of it for order 1). Kinks affect the engine and the judge alike, so three times the distance is allowed.
JUDGE_ERRORS = 3.0

# An order is reported as too low only if both halvings miss the declared order by this much and the engine's error is
# this many times the judge's: at kinks, the errors of engines and judge are of similar size.
MISSING_ORDER = 0.5
CLEAR_OF_JUDGE = 10.0


@dataclass(frozen=True)
class Convergence:
    """Convergence of one quantity of three runs to the judge's; root mean squares over the samples, in its unit.

    Attributes:
        errors: distance of each run from the judge's finest one, longest step first.
        limit: distance of the extrapolated run from it.
        judge_error: estimated error of the judge's finest run.
        allowed: largest acceptable `limit`.
        orders: orders measured with the first and with the second halving.
    """

    errors: tuple[float, ...]
    limit: float
    judge_error: float
    allowed: float
    orders: tuple[float, float]

    @property
    def agrees(self) -> bool:
        """True if the limit equals the judge's solution."""
        return self.limit <= self.allowed

    @property
    def blind(self) -> bool:
        """True if the judge's error is too large to detect the engine's."""
        return JUDGE_ERRORS * self.judge_error >= self.errors[0]

    def lacks(self, order: int) -> bool:
        """Return True if the runs clearly converge more slowly than a scheme of the given order."""
        clear = self.errors[-1] > CLEAR_OF_JUDGE * self.judge_error
        return clear and max(self.orders) < order - MISSING_ORDER


def continuous_samples(runs: Sequence[Run]) -> int:
    """Return the number of samples that precede the first solver failure in any run; tensions may jump after it."""
    count = min(len(run.rows) for run in runs)
    failed = np.array([run.solver_status[:count] != OK for run in runs]).any(axis=0)
    return int(np.argmax(failed)) if failed.any() else count


def converge(name: str, runs: Sequence[Run], judges: Sequence[Run], order: int, count: int) -> Convergence:
    """Return the convergence of a quantity of `runs` to that of `judges`.

    Args:
        name: quantity.
        runs: runs of the engine with the steps of LADDER.
        judges: runs of the judge with the same steps.
        order: declared order of the engine.
        count: number of samples to compare, from the first.
    """
    truth = judges[-1]
    with np.errstate(all="ignore"):
        first, second, third = (_deviation(name, run, truth, count) for run in runs)
        judge_error = _rms(_deviation(name, judges[-2], truth, count))
        gain = 2.0**order
        coarse, fine = (gain * second - first) / (gain - 1.0), (gain * third - second) / (gain - 1.0)
        spread = _rms(coarse - fine)
    errors = (_rms(first), _rms(second), _rms(third))
    round_off = QUANTITIES[name].allowed(truth)
    allowed = SPREADS * spread + SHARE * errors[-1] + JUDGE_ERRORS * judge_error + round_off
    return Convergence(
        errors,
        _rms(fine),
        judge_error,
        allowed if math.isfinite(allowed) else round_off,
        (local_order(*errors[:2]), local_order(*errors[1:])),
    )


def local_order(error: float, halved: float) -> float:
    """Return the order of convergence from the errors with a step and with half of it."""
    if not halved > 0.0:
        return math.inf
    return math.log2(error / halved) if error > 0.0 else -math.inf


def _deviation(name: str, run: Run, truth: Run, count: int) -> Array:
    return QUANTITIES[name].deviation(head(run, count), head(truth, count))


def _rms(values: Array) -> float:
    """Return the root mean square of the lengths of rows (K, d); infinite if any is not finite."""
    found = float(np.sqrt(np.mean(np.sum(values * values, axis=1)))) if len(values) else math.inf
    return found if math.isfinite(found) else math.inf
