"""Summary of a benchmark: one row per solver with the range of each figure over all robots."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

Ends = tuple[float, float] | None


def overview(figures: dict[str, Any]) -> list[dict[str, Any]]:
    """Return one dictionary per solver from a result of `cdpr.analysis.bench.run`: sums over robots, (min, max) pairs.

    Adversarial problems count only in the misclassified and invalid answers.
    """
    rows = []
    for solver in figures["solvers"]:
        on = [
            (robot, row) for robot in figures["robots"] for row in robot["results"] if row["solver"] == solver["name"]
        ]
        measured = [(robot, row) for robot, row in on if row["outcome"] == "measured"]
        done = [row for _, row in measured]
        misled = [
            row
            for robot in figures.get("adversaries", [])
            for row in robot["results"]
            if row["solver"] == solver["name"] and row["outcome"] == "measured"
        ]
        infeasible = sum(row["infeasible"] for row in done)
        found = sum(row["infeasible"] * row["on_infeasible"].get("INFEASIBLE", 0.0) for row in done)
        rows.append(
            {
                "name": solver["name"],
                "objective": solver["properties"].get("objective"),
                "max_redundancy": solver["properties"].get("max_redundancy"),
                "problem": solver["problem"],
                "robots": len(done),
                "unsupported": sum(row["outcome"] == "unsupported" for _, row in on),
                "failed": sum(row["outcome"] == "failed" for _, row in on),
                "redundancy": ends(robot["redundancy"] for robot, _ in measured),
                "coverage": ends(row["coverage"] for row in done),
                "misclassified": sum(row["misclassified"] for row in (*done, *misled)),
                "invalid_ok": sum(row["invalid_ok"] for row in (*done, *misled)),
                "asked": sum(row["problems"] for row in (*done, *misled)),
                "paths": sum(row["jumps"]["paths"] for row in done),
                "with_jump": sum(row["jumps"]["with_jump"] for row in done),
                "median_pinv": ends(row["time"]["median_pinv"] for row in done),
                "infeasible_detected": found / infeasible if infeasible else None,
            }
        )
    return rows


def ends(values: Iterable[float | None]) -> Ends:
    """Return (min, max) of the known values; None if there are none."""
    known = [value for value in values if value is not None]
    return (min(known), max(known)) if known else None
