"""Convergence of an engine to the judge's solution as the physics step shrinks.

An engine whose scheme nobody else offers cannot be compared at one step. Its solution for a vanishing step can: it is
extrapolated from runs with three steps and must be the judge's, within what the extrapolation and the judge may be off
by. An order measured from norms is no such bound: at kinks (slack cables, friction) and with long steps sound schemes
do not reach their order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.compare.differences import QUANTITIES, head
from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.tension.status import OK

LADDER = (1, 2, 4)  # by which the first step is divided

# Two extrapolations from the three steps differ by more than the better one is off, threefold for order 1 in a smooth
# loop. Kinks between two samples make single differences small by chance, so twice their difference is allowed.
SPREADS = 2.0

# Share of the finest run's error that the extrapolation may miss. The finest error is divided by at least 2 with each
# further halving; a fault of a fiftieth of it is what three steps can show.
SHARE = 0.02

# The judge's own error is at most the distance between its two finest runs (exactly a third of it for order 2, less for
# order 4, about all of it for order 1); kinks act on the engine as on the judge, so three times that is allowed.
JUDGE_ERRORS = 3.0

# Both halvings must show less than the declared order by this much before it counts as a fault, and the engine's error
# must be this many times the judge's: at kinks, engines and judge have errors of about the same size.
MISSING_ORDER = 0.5
CLEAR_OF_JUDGE = 10.0


@dataclass(frozen=True)
class Convergence:
    """How one quantity of three runs converges to the judge's; root mean squares over the samples, in its unit.

    Attributes:
        errors: distance of each run from the judge's finest one, longest step first.
        limit: distance of the extrapolated run from it.
        judge_error: estimated error of the judge's finest run.
        allowed: largest sound `limit`.
        orders: measured with the first and with the second halving.
    """

    errors: tuple[float, ...]
    limit: float
    judge_error: float
    allowed: float
    orders: tuple[float, float]

    @property
    def agrees(self) -> bool:
        """Return whether the limit is the judge's solution."""
        return self.limit <= self.allowed

    @property
    def blind(self) -> bool:
        """Return whether the judge's error is too large to tell the engine's from it."""
        return JUDGE_ERRORS * self.judge_error >= self.errors[0]

    def lacks(self, order: int) -> bool:
        """Return whether the runs converge more slowly than a scheme of `order`, beyond doubt."""
        clear = self.errors[-1] > CLEAR_OF_JUDGE * self.judge_error
        return clear and max(self.orders) < order - MISSING_ORDER


def continuous_samples(runs: Sequence[Run]) -> int:
    """Return how many samples all runs have before the solver fails in one: from there on the tensions may jump."""
    count = min(len(run.rows) for run in runs)
    failed = np.array([run.solver_status[:count] != OK for run in runs]).any(axis=0)
    return int(np.argmax(failed)) if failed.any() else count


def converge(name: str, runs: Sequence[Run], judges: Sequence[Run], order: int, count: int) -> Convergence:
    """Return how the quantity `name` of `runs` converges to that of `judges`, both with the steps of LADDER.

    The first `count` samples are looked at.
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
    """Return the order by which a halved step divides an error."""
    if not halved > 0.0:
        return math.inf
    return math.log2(error / halved) if error > 0.0 else -math.inf


def _deviation(name: str, run: Run, truth: Run, count: int) -> Array:
    return QUANTITIES[name].deviation(head(run, count), head(truth, count))


def _rms(values: Array) -> float:
    """Root mean square of the lengths of rows (K, d); infinite where one is not finite."""
    found = float(np.sqrt(np.mean(np.sum(values * values, axis=1)))) if len(values) else math.inf
    return found if math.isfinite(found) else math.inf
