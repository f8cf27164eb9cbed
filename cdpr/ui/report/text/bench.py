"""Benchmark results as text, for terminal, page and README."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from cdpr.analysis.bench.adversaries import BAND

Row = Mapping[str, Any]
Columns = Mapping[str, Callable[[Row], str]]

NOTHING = "-"


def percent(share: float | None) -> str:
    """Return a fraction as percentage; 0 % and 100 % only if exact."""
    if share is None:
        return NOTHING
    if 0.0 < share < 1.0:
        return f"{min(max(100.0 * share, 0.1), 99.9):.1f} %"
    return f"{100.0 * share:.0f} %"


def digits(value: float | None, count: int = 3) -> str:
    """Return a number with `count` significant digits, with exponent only if very small or very large."""
    return NOTHING if value is None else f"{value:.{count}g}" if not 10**count <= abs(value) < 1e6 else f"{value:.0f}"


def power(value: float | None) -> str:
    """Return only the order of magnitude."""
    return NOTHING if value is None else "0" if value == 0.0 else f"{value:.0e}"


def span(values: tuple[float, float] | None, text: Callable[[float], str]) -> str:
    """Return the minimum and maximum."""
    if values is None:
        return NOTHING
    low, high = (text(value) for value in values)
    return low if low == high else f"{low} to {high}"


def jumps(found: Row) -> str:
    """Return the number of paths with a jump, of all paths followed, and the largest jump."""
    if not found["paths"]:
        return NOTHING
    largest = f" ({digits(found['largest_N'], 2)} N)" if found["largest_N"] is not None else ""
    return f"{found['with_jump']}/{found['paths']}{largest}"


# Columns of a solver on one robot: heading and text of a cell.
COLUMNS: dict[str, Callable[[Row], str]] = {
    "coverage": lambda row: percent(row["coverage"]),
    "wrong": lambda row: str(row["misclassified"]),
    "bad OK": lambda row: str(row["invalid_ok"]),
    "residual": lambda row: power(row["worst_residual"]),
    "beyond N": lambda row: digits(row["worst_violation_N"], 2),
    "gap": lambda row: power(row["gap"]),
    "jumps": lambda row: jumps(row["jumps"]),
    "inf. found": lambda row: percent(row["on_infeasible"].get("INFEASIBLE", 0.0) if row["on_infeasible"] else None),
    "median us": lambda row: digits(row["time"]["median_us"]),
    "p99 us": lambda row: digits(row["time"]["p99_us"]),
    "pinv": lambda row: digits(row["time"]["median_pinv"]),
    "asked": lambda row: str(row["problems"]),
}

# Columns of a solver on adversarial problems.
MISLED: dict[str, Callable[[Row], str]] = {
    **{name: COLUMNS[name] for name in ("wrong", "bad OK", "residual", "beyond N", "coverage")},
    "edge": lambda row: percent(row["edge_coverage"]),
    **{name: COLUMNS[name] for name in ("inf. found", "asked")},
}

MEANING = {
    "coverage": "valid answers among the feasible problems",
    "wrong": "feasible problems reported as infeasible, infeasible ones reported as OK",
    "bad OK": "answers reported as OK that violate the limits or do not balance the wrench",
    "residual": "largest relative residual of an answer reported as OK",
    "beyond N": "largest limit violation of an answer reported as OK, N",
    "gap": "largest distance from the optimum of the declared objective (share of the largest limit or of the cost)",
    "jumps": "smooth paths with a jump of the tensions / paths evaluated (largest jump)",
    "inf. found": "infeasible problems reported as infeasible",
    "median us": "time of one call on a feasible problem, microseconds, median",
    "p99 us": "the same, 99th percentile",
    "pinv": "the median, in calls of numpy's pinv of a 6x8 matrix in the same run",
    "asked": "number of problems",
    "edge": f"valid answers to feasible problems too close to the edge to be judged by (slack below {BAND:g})",
}

OVERVIEW: dict[str, Callable[[Row], str]] = {
    "objective": lambda row: str(row["objective"] or NOTHING),
    "redundancy": lambda row: _redundancy(row),
    "coverage": lambda row: span(row["coverage"], percent),
    "jumps": lambda row: f"{row['with_jump']} of {row['paths']} paths" if row["paths"] else NOTHING,
    "median time (pinv)": lambda row: span(row["median_pinv"], lambda value: digits(value, 2)),
    "infeasible detected": lambda row: percent(row["infeasible_detected"]),
    "wrong": lambda row: str(row["misclassified"]) if row["robots"] else NOTHING,
    "bad OK": lambda row: str(row["invalid_ok"]) if row["robots"] else NOTHING,
}


def _redundancy(row: Row) -> str:
    """Return the redundancy that the solver declares, otherwise that of its measurements."""
    declared = row["max_redundancy"]
    if declared is None:
        return span(row["redundancy"], lambda value: f"{value:.0f}")
    return "any" if declared == "any" else f"up to {declared}"


def facts(robot: Row) -> str:
    """Return a line on a robot and its problems."""
    undecided = f", {robot['edge']} on the edge" if robot.get("edge") else ""
    undecided += f", {robot['undecided']} undecided" if robot["undecided"] else ""
    return (
        f"{robot['m']} cables, {robot['n']} degrees of freedom, redundancy {robot['redundancy']}; "
        f"{robot['feasible']} feasible and {robot['infeasible']} infeasible problems{undecided}"
    )


def cells(row: Row, columns: Columns = COLUMNS) -> list[str]:
    """Return the cells of a solver on one robot; empty if it was not measured."""
    return [text(row) for text in columns.values()] if row["outcome"] == "measured" else []


def overview_cells(row: Row) -> list[str]:
    """Return the cells of a solver over all robots; empty if it could not run."""
    return [text(row) for text in OVERVIEW.values()] if not row["problem"] else []
