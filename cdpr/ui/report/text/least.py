"""Smallest margin, clearance and stiffness along a motion, from `cdpr.analysis.workspace.path`, as text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from cdpr.mechanics.contacts import passing

# Title and unit of each figure.
NAMES = {
    "margin": ("capacity margin", "N, at rest,"),
    "clearance": ("least clearance", "m"),
    "stiffness": ("least stiffness", "N/m"),
}


def least_of(found: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Yield the title of each figure, and its value, time and cause."""
    for key, (title, unit) in NAMES.items():
        if key in found:
            least = found[key]
            by = f", {least['by']}" if least["by"] else ""
            if key == "clearance" and (through := passing(least["by"], least["value"])):
                yield title, f"none at {least['at_s']:.4g} s: {through}"
                continue
            yield title, f"{least['value']:.4g} {unit} at {least['at_s']:.4g} s{by}"
