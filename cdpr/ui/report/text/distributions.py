"""Tension distributions of a wrench, from `cdpr.analysis.distribution.comparison`, as aligned text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from cdpr.tension.checks import LIMIT_TOLERANCE
from cdpr.ui.report.style import shorten
from cdpr.ui.report.text.aligned import WIDTH, condition_number, row, table, turned, vector, wrapped

NAME = 24  # characters of a solver's name
WIDE = 1e8  # larger numbers are written with an exponent
CABLE = 10  # characters of a cable's name above its tensions


def lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the problem and tables of the results; only long names make lines longer than 120 characters."""
    pose, wrench = figures["pose"], figures["wrench"]
    yield (f"{figures['robot']} at {vector(pose['position_m'])} m{turned(pose['orientation_wxyz'])} ({pose['source']})")
    yield row("wrench", f"{vector(wrench['value'])} N, N m ({wrench['source']})")
    size = f"n = {figures['n']}: {', '.join(figures['dof'])}; m = {figures['m']} cables"
    yield row("degrees of freedom", f"{size}, redundancy r = m - n = {figures['redundancy']}")
    yield row("limits", _limits(figures["cables"]))
    yield row("rank of W", f"{figures['rank']} of n = {figures['n']}")
    yield row("condition number", condition_number(figures["condition_number"], figures))
    yield row("feasible", _feasible(figures))
    yield from _answers(figures["solvers"])
    yield from _tensions(figures)
    for answer in figures["solvers"]:
        if answer["reason"]:
            yield from wrapped(f"  {answer['solver']}: {answer['reason']}", 4)
    if (why := no_picture(figures)) is not None:
        yield f"  no picture: {why}"


def no_picture(figures: dict[str, Any]) -> str | None:
    """Return the reason why the distributions cannot be drawn; None if they can."""
    if figures["null_space"] is None:
        return "no tensions balance the wrench, with any limits"
    r = figures["null_space"]["dimension"]
    if r == 0:
        return "the wrench determines the tensions (r = 0)"
    if r > 2 and figures["ranges_N"] is None:
        return "some limits are infinite, so tensions may be unbounded"
    return None


def _limits(cables: list[dict[str, Any]]) -> str:
    texts = [f"{cable['tension_min_N']:g} to {highest(cable):g}" for cable in cables]
    if len(set(texts)) == 1:
        return f"{texts[0]} N, all cables"
    low, high = min(cable["tension_min_N"] for cable in cables), max(map(highest, cables))
    return f"{low:g} to {high:g} N, not the same for all cables"


def highest(cable: dict[str, Any]) -> float:
    """Return a cable's highest tension, N; infinite limits have no JSON form."""
    value = cable["tension_max_N"]
    return math.inf if value is None else float(value)


def _feasible(figures: dict[str, Any]) -> str:
    margin = figures["largest_margin_N"]
    if not figures["reachable"]:
        return "no: the cables cannot exert this wrench, whatever their tensions"
    if figures["feasible"]:
        if margin is None:  # infinite in JSON
            return "yes; every cable is locked"
        return f"yes; the best distribution stays {margin:.6g} N from all limits"
    return "no" + ("" if margin is None else f"; all limits would have to be wider by {-margin:.6g} N")


def _answers(answers: list[dict[str, Any]]) -> Iterator[str]:
    head = ["solver", "status", "2-norm (N)", "margin (N)", "at limits", "residual (N)", "time (us)*"]
    rows = [
        [
            shorten(answer["solver"], NAME),
            _status(answer),
            _fixed(answer["norm_N"], 3),
            _fixed(answer["margin_N"], 3),
            "-" if answer["at_limit"] is None else str(answer["at_limit"]),
            "-" if answer["residual_N"] is None else f"{answer['residual_N']:.1e}",
            _fixed(answer["time_us"], 1),
        ]
        for answer in answers
    ]
    yield from table([head, *rows], left=2)
    yield "  * median of repeated calls on this machine; not judged"


def _status(answer: dict[str, Any]) -> str:
    if answer["status"] != "OK" or answer["admissible"]:
        return f"{answer['status'] or 'none'}{'' if answer['true'] else ', untrue'}"
    return "OK, but beyond" if answer["true"] else "OK, untrue"


def _fixed(value: float | None, digits: int) -> str:
    """Return a number with `digits` decimals and without negative zero; with an exponent if very large."""
    if value is None:
        return "-"
    return f"{value:z.{digits}f}" if abs(value) < WIDE else f"{value:.3g}"


def _tensions(figures: dict[str, Any]) -> Iterator[str]:
    """Yield tables of the tensions, each with as many cables as fit into a line."""
    cables = figures["cables"]
    rows = [answer for answer in figures["solvers"] if answer["tension_N"] is not None]
    if not rows:
        return
    cells = [[_tension(t, cable) for t, cable in zip(answer["tension_N"], cables, strict=True)] for answer in rows]
    heads = [shorten(cable["name"], CABLE) + " " for cable in cables]  # space for the mark
    widest = max(len(cell) for line in [heads, *cells] for cell in line)
    first = max(len("tension (N)"), *(len(shorten(answer["solver"], NAME)) for answer in rows))
    count = max(1, (WIDTH - 2 - first) // (widest + 2))
    for start in range(0, len(cables), count):
        part = slice(start, start + count)
        block = [["tension (N)", *(f"{head:>{widest}}" for head in heads[part])]]
        block += [
            [shorten(answer["solver"], NAME), *(f"{cell:>{widest}}" for cell in line[part])]
            for answer, line in zip(rows, cells, strict=True)
        ]
        yield from table(block)
    marks = {mark for line in cells for cell in line for mark in cell[-1]} - {" "}
    if marks:
        meaning = {"<": "at its lowest tension", ">": "at its highest", "!": "beyond a limit"}
        yield "  " + ", ".join(f"{mark} {text}" for mark, text in meaning.items() if mark in marks)


def _tension(t: float | None, cable: dict[str, Any]) -> str:
    if t is None:
        return "NaN!"
    below, above = cable["tension_min_N"] - t, t - highest(cable)
    if max(below, above) > LIMIT_TOLERANCE:
        mark = "!"
    else:
        mark = "<" if below >= -LIMIT_TOLERANCE else ">" if above >= -LIMIT_TOLERANCE else " "
    return f"{_fixed(t, 2)}{mark}"
