"""Figures of a design: convergence of its goal, and its Pareto front."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.analysis.design import Designed
from cdpr.model.robot import Array
from cdpr.ui.report.figures.svg import OnPage
from cdpr.ui.report.style import CABLES, INK, SOFT

WIDTH, HEIGHT = 6.4, 3.2  # in, sheet
LEFT, RIGHT, LOWER, ABOVE = 0.95, 0.2, 0.6, 0.25  # in, margins
AIR = 0.05  # around the values, relative to their extent
FEW = 40  # robots on a front above which small markers are used
LOWEST = 5.0  # per cent of values that may be cut off at the bad end, where random candidates scatter widely

DOT: dict[str, Any] = {"color": SOFT, "linestyle": "", "marker": "o", "markersize": 2.2, "zorder": 2}
LINE: dict[str, Any] = {"color": CABLES[0], "linewidth": 1.8, "zorder": 3}
FRONT: dict[str, Any] = {"color": CABLES[0], "linewidth": 1.2, "marker": "o", "markersize": 4.5, "zorder": 3}
BEFORE: dict[str, Any] = {"color": CABLES[1], "linestyle": "", "marker": "D", "markersize": 8, "zorder": 4}
CHOSEN: dict[str, Any] = {"color": INK, "linestyle": "", "marker": "*", "markersize": 11, "zorder": 5}


def convergence(found: Designed) -> OnPage:
    """Draw the goal of each feasible candidate, and the best value so far, of a design with one goal."""
    number, value = _feasible(found, 0)
    better = np.minimum if found.design.section.wanted[0].way == "minimise" else np.maximum
    best = better.accumulate(value) if len(value) else value
    last = float(len(found.rows) - 1)
    sheet, frame = _frame((-AIR * last / 2.0, (1.0 + AIR) * last), _span(value, best))
    frame.line(number, value, DOT)
    if len(best):
        x = np.repeat(np.append(number, last), 2)[1:-1]
        frame.line(x, np.repeat(best, 2), LINE)
    before = found.goals(found.before)[0]
    if found.before.score.feasible and before is not None:
        frame.line([0.0], [before], BEFORE)
    _name(frame, "evaluation", found.design.section.wanted[0].label)
    return sheet


def pareto(found: Designed, first: int, second: int) -> OnPage:
    """Draw two goals: all feasible candidates, the Pareto front, the initial robot and the best one."""
    _, x = _feasible(found, first)
    _, y = _feasible(found, second)
    front = np.array([found.goals(row) for row in found.front], dtype=float).reshape(-1, len(found.goals(found.before)))
    front = front[np.argsort(front[:, first], kind="stable")]
    sheet, frame = _frame(_span(x, front[:, first]), _span(y, front[:, second]))
    frame.line(x, y, DOT)
    looks = {**FRONT, "markersize": FRONT["markersize"] if len(front) <= FEW else DOT["markersize"]}
    frame.line(front[:, first], front[:, second], looks if front.shape[1] == 2 else {**looks, "linestyle": ""})
    for row, look in ((found.before, BEFORE), (found.best, CHOSEN)):
        known = found.goals(row)
        if row.score.feasible:
            frame.line([known[first]], [known[second]], look)
    goals = found.design.section.wanted
    _name(frame, goals[first].label, goals[second].label)
    return sheet


def _feasible(found: Designed, goal: int) -> tuple[Array, Array]:
    """Return the numbers and goal values of the feasible candidates, each (k,)."""
    rows = [row for row in found.rows[1:] if row.score.feasible]
    values = [found.goals(row)[goal] for row in rows]
    return np.array([row.number for row in rows], dtype=float), np.array(values, dtype=float)


def _span(values: Array, kept: Array) -> tuple[float, float]:
    """Return an axis range that contains all of `kept` and most of `values`."""
    if not len(values):
        return 0.0, 1.0
    ends = np.percentile(values, [LOWEST, 100.0 - LOWEST])
    together = np.concatenate([ends, kept])
    low, high = float(together.min()), float(together.max())
    air = AIR * (high - low) or 0.5 * abs(high) or 1.0
    return low - air, high + air


def _frame(x: Sequence[float], y: Sequence[float]) -> tuple[OnPage, Any]:
    sheet = OnPage(WIDTH, HEIGHT)
    frame = sheet.frame((LEFT, LOWER, WIDTH - LEFT - RIGHT, HEIGHT - LOWER - ABOVE))
    frame.scale(x=(x[0], x[1]), y=(y[0], y[1]))
    return sheet, frame


def _name(frame: Any, x: str, y: str) -> None:
    frame.time_axis(7)
    frame.label_time(x, 0.3)
    frame.value_axis(y, 0.68, powers=False)
