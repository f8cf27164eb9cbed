"""Figures of one solver on the problems of one robot.

An answer is valid if the status is OK, all tensions are finite, |W t - wrench| is at most 1e-6 of the wrench (or of 1
N; moments divided by the characteristic length), and no tension exceeds a limit by more than 1e-6 N. Validity is
checked here, whatever the solver declares. Adversarial problems, some of millinewtons, use their largest tension in
place of 1 N; if it is below 1 N, the limits may be exceeded by 1e-6 of it.

- coverage: share of valid answers among the feasible problems.
- edge_coverage: the same among problems that are certainly feasible but closer to infeasibility than the band of 1e-9
  (adversarial problems only; they enter no other figure).
- misclassified: feasible problems reported as INFEASIBLE, and infeasible ones reported as OK unless the solver declares
  that it ignores the limits.
- invalid_ok: problems reported as OK with an invalid answer.
- worst_residual (relative, as above) and worst_violation_N: largest values of all answers with status OK.
- gap: distance of valid answers from the optimum of the declared objective, found by another library. For unique optima
  (min_norm, mid_range): the largest difference of a tension as a share of the largest limit. For one_norm: the relative
  excess of the sum of tensions. For max_slack: the missing margin as a share of the largest limit.
- jumps: number of paths with a jump of the tensions, and the largest jump, among the smooth, feasible paths with
  answers at half of the points or more. Jumps between the points may be missed.
- on_feasible, on_infeasible: share of each status.
- time: wall time of a call on feasible problems, median and 99th percentile; the same as ratios to the median of
  numpy.linalg.pinv of a 6x8 matrix called in between; and the median on infeasible problems.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.bench.continuity import Path, steepest
from cdpr.analysis.bench.oracle import UNIQUE, Oracle
from cdpr.analysis.bench.problems import Problems
from cdpr.analysis.bench.solver_calls import Answers
from cdpr.model.robot import Array
from cdpr.tension import Status
from cdpr.tension.checks import LIMIT_TOLERANCE, RESIDUAL_TOLERANCE

STEPS = 300  # steps of a path
PLACES = 2  # steepest steps of each path that are refined
HALVINGS = 26  # bisections of a step; the rest of a smooth step is round-off

# Change between equal problems, as a share of the largest limit, that is no jump: above the scatter of converged
# iterative solvers, and far below the distance of two vertices of the feasible set.
NOISE = 1e-5

USABLE = 0.5  # share of a path's points that need an answer


@dataclass(frozen=True, eq=False)
class Judgement:
    """Independent check of K answers."""

    residual: Array  # (K,), relative
    violation: Array  # (K,), N, by which a limit is exceeded; 0 or less if none is
    valid: NDArray[np.bool_]


def judge(problems: Problems, answers: Answers) -> Judgement:
    """Return the check of all answers; figures are NaN for non-finite answers."""
    t, unit = answers.tension, problems.units
    lack = problems.weights * (np.einsum("knm,km->kn", problems.W, t) - problems.wrench)
    load = np.linalg.norm(problems.weights * problems.wrench, axis=1)
    residual = np.linalg.norm(lack, axis=1) / np.maximum(unit, load)
    violation = np.maximum(problems.t_min - t, t - problems.t_max).max(axis=1)
    within = violation <= LIMIT_TOLERANCE * np.minimum(1.0, unit)
    sound = np.isfinite(t).all(axis=1) & (residual <= RESIDUAL_TOLERANCE) & within
    return Judgement(residual, violation, sound & (answers.status == Status.OK))


def accuracy(problems: Problems, oracle: Oracle, answers: Answers, properties: Mapping[str, Any]) -> dict[str, Any]:
    """Return all figures but jumps and times."""
    judged, status = judge(problems, answers), answers.status
    ok = status == Status.OK
    wrong = _count(oracle.feasible & (status == Status.INFEASIBLE))
    if properties.get("respects_bounds", True):
        wrong += _count(oracle.infeasible & ok)
    feasible, edge = _count(oracle.feasible), _count(oracle.edge)
    return {
        "problems": len(problems),
        "feasible": feasible,
        "infeasible": _count(oracle.infeasible),
        "coverage": _count(judged.valid & oracle.feasible) / feasible if feasible else None,
        "edge_coverage": _count(judged.valid & oracle.edge) / edge if edge else None,
        "misclassified": wrong,
        "invalid_ok": _count(ok & ~judged.valid),
        "worst_residual": _worst(judged.residual[ok]),
        "worst_violation_N": None if (worst := _worst(judged.violation[ok])) is None else max(0.0, worst),
        "gap": gap(problems, oracle, answers, judged.valid & oracle.feasible, properties.get("objective")),
        "on_feasible": shares(status[oracle.feasible]),
        "on_infeasible": shares(status[oracle.infeasible]),
    }


def gap(
    problems: Problems, oracle: Oracle, answers: Answers, valid: NDArray[np.bool_], objective: object
) -> float | None:
    """Return the largest distance of valid answers from the optimum; None if the optimum is unknown."""
    if not isinstance(objective, str) or objective not in oracle.optima:
        return None
    t, best = answers.tension[valid], oracle.optima[objective][valid]
    low, high = problems.robot.tension_min, problems.robot.tension_max
    scale = float(high.max())
    if objective in UNIQUE:
        return _worst(np.abs(t - best).max(axis=1) / scale)
    if objective == "one_norm":
        return _worst((t.sum(axis=1) - best.sum(axis=1)) / best.sum(axis=1))
    slack = np.minimum(t - low, high - t).min(axis=1)
    return _worst((oracle.margin[valid] - slack) / scale)


def jumps(paths: Sequence[Path], answer: Callable[[Path, float], Array | None]) -> dict[str, Any]:
    """Count the paths with a jump; `answer(path, s)` returns tensions (m,) or None."""
    usable, broken, largest = 0, 0, 0.0
    for path in paths:
        found = steepest(lambda s, path=path: answer(path, s), STEPS, HALVINGS, PLACES)  # type: ignore[misc]
        if found.answered < USABLE:
            continue
        usable += 1
        if found.jumps(NOISE * float(path.robot.tension_max.max())):
            broken += 1
            largest = max(largest, found.change)
    return {"paths": usable, "with_jump": broken, "largest_N": largest if broken else None}


def times(oracle: Oracle, answers: Answers) -> dict[str, Any]:
    """Return the times of a call, us, and as ratios to pinv."""
    pinv = float(np.median(answers.pinv_ns))
    easy, hard = answers.nanoseconds[oracle.feasible], answers.nanoseconds[oracle.infeasible]
    median, p99 = (float(np.percentile(easy, q)) if len(easy) else None for q in (50, 99))
    return {
        "median_us": None if median is None else 1e-3 * median,
        "p99_us": None if p99 is None else 1e-3 * p99,
        "infeasible_median_us": 1e-3 * float(np.median(hard)) if len(hard) else None,
        "pinv_us": 1e-3 * pinv,
        "median_pinv": None if median is None else median / pinv,
        "p99_pinv": None if p99 is None else p99 / pinv,
    }


def shares(status: NDArray[np.int64]) -> dict[str, float]:
    """Return the share of each status that occurs, by name."""
    counts = {one.name: _count(status == one) for one in Status}
    return {name: count / len(status) for name, count in counts.items() if count}


def _count(which: NDArray[np.bool_]) -> int:
    return int(np.count_nonzero(which))


def _worst(values: Array) -> float | None:
    """Return the largest finite value; None if there is none."""
    finite = values[np.isfinite(values)]
    return float(finite.max()) if len(finite) else None
