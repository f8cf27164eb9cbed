"""Errors and consistency of an estimate as lines of a summary."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cdpr.ui.report.text.aligned import unit_for

LINES = (
    ("estimate: position", "position_error_m", "m"),
    ("estimate: attitude", "orientation_error_rad", "rad"),
    ("estimate: velocity", "velocity_error_m_s", "m/s"),
)


def estimate_lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of a summary on the errors of the estimate, and on NIS and NEES; none without an estimator."""
    found = figures.get("estimate")
    if found is None:
        return
    for name, key, base in LINES:
        scale, unit = unit_for(found[key].values(), base)
        values = "   ".join(f"{part} {scale * value:.4g} {unit}" for part, value in found[key].items())
        yield f"{name:<20}error {values}"
    for key in ("nis", "nees"):
        if each := found.get(key):
            share = 100.0 * each["inside_95_percent"]
            yield f"{key.upper():<20}mean {each['mean_per_value']:.4g} per value, {share:.3g} % in the 95 % band"
