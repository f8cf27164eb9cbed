"""Adversarial problems for tension solvers, with exactly known answers.

Robots in general poses are easy: their columns are far from parallel and their limits far from the solution. These
problems have parallel, opposite and equal columns, zero columns and rows, dependent rows, arms of a hundred metres,
cables at a limit or locked, sets of admissible tensions as thin as 1e-12 of the tensions, loads from millinewtons to
meganewtons, and wrenches just out of reach.

No solver is involved. The entries are dyadic rationals of few bits, so that W t is computed without rounding for
tensions t chosen first (`certify` repeats it in fractions): t solves the floating-point problem exactly. Infeasible
problems are proved by Farkas' lemma: for some y, y . wrench exceeds the largest y . W t by a gap far above round-off.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cdpr.model import Cable, Platform, Robot
from cdpr.model.robot import Array, frozen_array

# A problem must be reported as feasible if all its limits could be narrowed by this share of the largest tension;
# closer to infeasibility, round-off decides. Infeasible problems here are farther from feasibility.
BAND = 1e-9

ARM = 128.0  # m, a power of two
BITS = 20  # fractional bits of entries from directions
LARGEST = 1024  # tensions are integers below this, then scaled by a power of two
SCALES = -20, 10  # exponents of two: the largest tension is from 1e-3 to 1e6 N
THINNEST, THIN = -40, -20  # exponents of two: slack of a thin set as a share of LARGEST, 1e-12 to 1e-6
GAPS = -26, 0  # exponents of two: relative distance of unreachable wrenches, at least 15 times the band

# Degrees of freedom and number of cables of the robots; the last two have more redundancy than rows.
SIZES = (
    (("x",), 2),
    (("x", "z"), 3),
    (("x", "z"), 4),
    (("x", "y", "z"), 3),
    (("x", "z", "ry"), 4),
    (("x", "y", "z"), 5),
    (("x", "y", "z", "rx", "ry", "rz"), 7),
    (("x", "y", "z", "rx", "ry", "rz"), 8),
    (("x", "y", "z", "rx", "ry", "rz"), 12),
    (("x", "z"), 6),
    (("x", "y", "z", "rx", "ry", "rz"), 14),
)


@dataclass(frozen=True, eq=False)
class Adversaries:
    """K problems W t = wrench, low <= t <= high for a robot with n degrees of freedom and m cables.

    `solution` (K, m) solves the feasible problems exactly; `certificate` (K, n) is the y that proves the others
    infeasible.
    """

    robot: Robot
    W: Array  # (K, n, m)
    wrench: Array  # (K, n)
    low: Array  # (K, m)
    high: Array  # (K, m)
    feasible: NDArray[np.bool_]  # (K,)
    solution: Array  # (K, m), N; NaN if infeasible
    certificate: Array  # (K, n); NaN if feasible
    kind: list[str]  # kind of W and of the limits

    def __len__(self) -> int:
        return len(self.W)

    @property
    def slack(self) -> Array:
        """Lower bound of the share of the largest tension by which all limits may be narrowed, (K,); NaN if infeasible.

        Locked cables are ignored.
        """
        room = np.minimum(self.solution - self.low, self.high - self.solution)
        room = np.where(self.low == self.high, np.inf, room).min(axis=1)
        return np.where(self.feasible, room / np.abs(self.high).max(axis=1), np.nan)


def robots() -> list[Robot]:
    """Return a robot for each of `SIZES`; of its geometry only the characteristic length, 1 m, matters."""
    found = []
    for dof, m in SIZES:
        angle = 2.0 * np.pi * np.arange(m) / m
        B = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
        cables = tuple(Cable(10.0 * b, b, 0.0, float(LARGEST), name=f"c{i + 1}") for i, b in enumerate(B))
        platform = Platform(10.0, frozen_array(np.eye(3)), frozen_array([0.0, 0.0, 0.0]))
        found.append(Robot(platform, cables, dof, name=f"adversaries, {m} cables for {len(dof)}"))
    return found


def adversaries(robot: Robot, count: int, seed: int) -> Adversaries:
    """Return problems for a robot, each with random kinds of matrix and limits; one in three is infeasible.

    Problem k depends only on the robot's size, its rows, the seed and k.
    """
    n, m = robot.n, robot.m
    W, wrench = np.empty((count, n, m)), np.empty((count, n))
    low, high = np.empty((count, m)), np.empty((count, m))
    solution, certificate = np.full((count, m), np.nan), np.full((count, n), np.nan)
    feasible, kind = np.ones(count, dtype=bool), []
    moments = np.array(robot.rows) >= 3
    for k in range(count):
        rng = np.random.default_rng([seed, n, m, k])
        matrix, first = _matrix(moments, m, rng)
        W[k] = matrix
        t = rng.integers(1, LARGEST, m).astype(float)
        low[k], high[k], second = _limits(t, rng)
        if first.startswith("twin"):  # with different limits, the twins would differ
            t[1], low[k, 1], high[k, 1] = t[0], low[k, 0], high[k, 0]
        wrench[k] = W[k] @ t
        scale = 2.0 ** rng.integers(*SCALES, endpoint=True)
        kind.append(f"{first}, {second}")
        if k % 3 == 2:
            y = rng.integers(-3, 4, n).astype(float)
            y[rng.integers(n)] = 1.0
            if first == "dependent rows" and rng.integers(2):  # outside the range of W for any tensions
                y = _left_null(W[k], y)
            wrench[k], feasible[k] = _out_of_reach(W[k], wrench[k], low[k], high[k], y, rng), False
            certificate[k] = y
        else:
            solution[k] = t * scale
        for vectors in (wrench, low, high):
            vectors[k] *= scale
    for array in (W, wrench, low, high):
        array.flags.writeable = False  # solvers must not change the problems of the next one
    return Adversaries(
        robot=robot,
        W=W,
        wrench=wrench,
        low=low,
        high=high,
        feasible=feasible,
        solution=solution,
        certificate=certificate,
        kind=kind,
    )


def _matrix(moments: NDArray[np.bool_], m: int, rng: np.random.Generator) -> tuple[Array, str]:
    """Return a matrix (n, m) of dyadic rationals, and its kind."""
    n = len(moments)
    W: Array
    if rng.integers(2):
        W = rng.integers(-3, 4, (n, m)).astype(float)
    else:
        W = rng.normal(size=(n, m))
        W /= np.linalg.norm(W, axis=0)
        W = np.round(W * 2.0**BITS) / 2.0**BITS
    kinds = ["general", "parallel", "opposite", "twins", "nearly parallel", "zero column"]
    kinds += ["dependent rows", "zero row"] if n > 1 else []
    kinds += ["long arms"] if moments.any() else []
    kind = kinds[rng.integers(len(kinds))]
    if kind == "parallel":
        for j in range(1, rng.integers(2, m + 1)):
            W[:, j] = W[:, 0] * 2.0 ** rng.integers(-2, 3)
    elif kind == "opposite":
        W[:, 1] = -W[:, 0] * 2.0 ** rng.integers(-2, 3)
    elif kind == "twins":
        W[:, 1] = W[:, 0]
    elif kind == "nearly parallel":
        W[:, 1] = W[:, 0] + 2.0**-BITS * rng.integers(-1, 2, n)
    elif kind == "zero column":
        W[:, 0] = 0.0
    elif kind == "dependent rows":
        W[-1] = W[0] if rng.integers(2) else W[:-1].sum(axis=0)
    elif kind == "zero row":
        W[-1] = 0.0
    elif kind == "long arms":
        W[moments] *= ARM
    order = rng.permutation(m) if kind != "twins" else np.arange(m)
    return W[:, order], kind


def _limits(t: Array, rng: np.random.Generator) -> tuple[Array, Array, str]:
    """Return limits (m,) that contain `t` (m,), and their kind."""
    m = len(t)
    low, high = t - np.minimum(rng.integers(1, 100, m), t), t + rng.integers(1, 1000, m)
    some = rng.random(m) < rng.random()
    kind = ("wide", "at limits", "locked", "sliver", "narrow", "narrow and at limits")[rng.integers(6)]
    if kind in ("at limits", "narrow and at limits"):
        upper = rng.random(m) < 0.5
        low, high = np.where(some & ~upper, t, low), np.where(some & upper, t, high)
    elif kind == "locked":
        low, high = np.where(some, t, low), np.where(some, t, high)
    thin = LARGEST * 2.0 ** rng.integers(THINNEST, THIN, endpoint=True)
    if kind == "sliver":  # on both sides of every cable
        low, high = t - thin, t + thin
    elif kind.startswith("narrow"):
        low = np.where(some & (low < t), t - thin, low)
        high = np.where(some & (high > t), t + thin, high)
    return low, high, kind


def _left_null(W: Array, otherwise: Array) -> Array:
    """Return a y with y W = 0 if the last row is the first one or the sum of the others; else `otherwise`."""
    n = len(W)
    for y in (np.eye(n)[-1] - np.eye(n)[0], 2.0 * np.eye(n)[-1] - np.ones(n)):
        if not (y @ W).any():
            return np.asarray(y)
    return otherwise


def _out_of_reach(W: Array, wrench: Array, low: Array, high: Array, y: Array, rng: np.random.Generator) -> Array:
    """Return a wrench beyond the reach of the cables along y."""
    c = W.T @ y
    most = float(np.maximum(c * low, c * high).sum())
    share = 2.0 ** rng.integers(*GAPS, endpoint=True)
    gap = share * max(float(np.abs(c).sum() * high.max()), float(np.linalg.norm(y) * np.linalg.norm(wrench)), 1.0)
    return np.asarray(wrench + y * ((most + gap - y @ wrench) / (y @ y)))


def certify(problems: Adversaries, k: int) -> float:
    """Prove the stated property of problem k in rational arithmetic; AssertionError if it is false.

    Returns:
        Share of the largest tension by which all limits may be narrowed (feasible) or must be widened (infeasible).
    """
    W, wrench, low, high = (
        _fractions(array[k]) for array in (problems.W, problems.wrench, problems.low, problems.high)
    )
    n, m = W.shape
    largest = max(map(abs, high))
    if problems.feasible[k]:
        t = _fractions(problems.solution[k])
        assert all(sum(W[j] * t) == wrench[j] for j in range(n))
        assert all(low[i] <= t[i] <= high[i] for i in range(m))
        room = (min(t[i] - low[i], high[i] - t[i]) for i in range(m) if low[i] < high[i])
        return float(min(room, default=largest) / largest)
    y = _fractions(problems.certificate[k])
    c = [sum(y * W[:, i]) for i in range(m)]
    gap = sum(y * wrench) - sum(max(c[i] * low[i], c[i] * high[i]) for i in range(m))
    assert gap > 0
    push, load = sum(map(abs, c)) * largest, sum(abs(y * wrench))
    return float(min(gap / push if push else 1, gap / load if load else 1))


def _fractions(values: Array) -> NDArray[np.object_]:
    return np.asarray(np.vectorize(Fraction, otypes=[object])(values))
