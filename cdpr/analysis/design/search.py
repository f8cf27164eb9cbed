"""Seeded searches in the unit cube that propose candidates until the budget is exhausted.

The candidates depend only on the seed and on the returned scores, not on time or on the number of threads, so that a
search can be replayed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from cdpr.analysis.design.evaluations import SpentError
from cdpr.analysis.design.rank import Score, select
from cdpr.base.errors import PluginError
from cdpr.model.robot import Array

Evaluate = Callable[[Array], list[Score]]

FEWEST, EACH = 12, 4  # minimum candidates per generation, and candidates per variable ...
GENERATIONS = 20  # ... unless fewer than this many generations would be left

WEIGHT, CROSSOVER = (0.4, 0.9), 0.9  # differential evolution with several goals: Storn and Price 1997
STEP = 0.3  # cma: initial standard deviation; bounds are at 0 and 1
MOST = 10**9  # generations; the budget of evaluations ends a search earlier


def size(given: int | None, variables: int, evaluations: int) -> int:
    """Return the number of candidates of a generation."""
    return given or max(FEWEST, min(EACH * variables, evaluations // GENERATIONS))


def run_search(kind: str, evaluate: Evaluate, start: Array, seed: int, population: int) -> None:
    """Run a search until the budget is exhausted; its first candidate is `start` (n,), as shares of the bounds."""
    try:
        SEARCHES[kind](evaluate, start, seed, population)
    except SpentError:
        return


def require(kind: str) -> list[str]:
    """Return the packages that a search needs besides numpy.

    Raises:
        PluginError: if one is not installed.
    """
    needed = {"differential_evolution": "scipy", "cma": "cma"}.get(kind)
    if needed is None:
        return []
    try:
        __import__(needed)
    except ImportError as error:
        raise PluginError(
            f"the optimizer {kind} needs {needed}, which is not installed: pip install 'cdpr[design]'"
        ) from error
    return [needed]


def spread(rng: np.random.Generator, count: int, start: Array) -> Array:
    """Return `count` points (count, n) of a Latin hypercube; the first is replaced by `start`."""
    n = len(start)
    cells = np.stack([rng.permutation(count) for _ in range(n)], axis=1)
    points = (cells + rng.random((count, n))) / count
    points[0] = start
    return np.asarray(points)


def _random(evaluate: Evaluate, start: Array, seed: int, population: int) -> None:
    """Propose uniformly random candidates, the baseline of all searches."""
    rng = np.random.default_rng(seed)
    evaluate(start[None])
    while True:
        evaluate(rng.random((population, len(start))))


def _differential_evolution(evaluate: Evaluate, start: Array, seed: int, population: int) -> None:
    """Run scipy's differential evolution generation by generation (Storn and Price 1997, best/1/bin)."""
    from scipy.optimize import differential_evolution

    def generation(function: Any, points: Iterable[Array]) -> list[float]:
        return [each.scalar for each in evaluate(np.array(list(points)))]

    rng = np.random.default_rng(seed)
    differential_evolution(
        lambda point: 0.0,  # unused: `generation` evaluates
        [(0.0, 1.0)] * len(start),
        init=spread(rng, population, start),
        maxiter=MOST,
        tol=0.0,
        atol=-1.0,  # never converged: the search continues on plateaus, where a generation has equal scores
        polish=False,
        updating="deferred",
        workers=generation,
        seed=rng,  # name until scipy 1.15, still accepted
    )


def _cma(evaluate: Evaluate, start: Array, seed: int, population: int) -> None:
    """Run CMA-ES by the package cma (Hansen), with random restarts after convergence."""
    import cma

    rng = np.random.default_rng(seed)
    begin = np.clip(start, 0.05, 0.95)  # at a bound, half of the samples would be rejected
    evaluate(start[None])
    while True:
        options = {
            "bounds": [0.0, 1.0],
            "popsize": population,
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": np.nan,  # a seed would reset numpy's global generator
            "verbose": -9,
            "verb_log": 0,
            "tolfunhist": 0.0,
        }
        search = cma.CMAEvolutionStrategy(begin, STEP, options)
        while not search.stop():
            points = search.ask()
            search.tell(points, [each.scalar for each in evaluate(np.array(points))])
        begin = rng.random(len(start))


def _nsga2(evaluate: Evaluate, start: Array, seed: int, population: int) -> None:
    """Run differential evolution with NSGA-II's selection for several goals (Kukkonen and Lampinen, GDE3, CEC 2005)."""
    rng = np.random.default_rng(seed)
    points = spread(rng, population, start)
    scores = evaluate(points)
    while True:
        others = np.argsort(rng.random((population, population)), axis=1)
        others = np.array([row[row != i][:3] for i, row in enumerate(others)])
        a, b, c = (points[others[:, k]] for k in range(3))
        moved = a + rng.uniform(*WEIGHT, (population, 1)) * (b - c)
        taken = rng.random(points.shape) < CROSSOVER
        taken[np.arange(population), rng.integers(len(start), size=population)] = True
        trials = np.where(taken, moved, points)
        trials = np.where(trials < 0.0, 0.5 * points, np.where(trials > 1.0, 0.5 * (points + 1.0), trials))  # half way
        together = [*scores, *evaluate(trials)]
        kept = select(together, population)
        points, scores = np.concatenate([points, trials])[kept], [together[i] for i in kept]


SEARCHES: dict[str, Callable[[Evaluate, Array, int, int], None]] = {
    "differential_evolution": _differential_evolution,
    "nsga2": _nsga2,
    "cma": _cma,
    "random": _random,
}
