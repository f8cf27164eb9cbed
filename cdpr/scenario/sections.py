"""Sections of scenario files in the order of their tabs, for the window, the documentation and the help of commands.

A field of `ScenarioSection` declares its tab with `json_schema_extra=tab(...)`; everything else comes from its
description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cdpr.base.fields import TAB

# Tabs of the window and parts of the documentation, with their titles. A section without a tab is in the last one.
TABS = {"robot": "Robot", "motion": "Motion", "control": "Control", "events": "Events", "simulation": "Simulation"}
OTHER = "simulation"


@dataclass(frozen=True)
class SectionInfo:
    """Section or key at the top of a scenario file.

    Attributes:
        key: its key.
        tab: key of `TABS`.
        text: description.
        required: True if files must contain it.
    """

    key: str
    tab: str
    text: str
    required: bool


def sections_of(schema: Mapping[str, Any]) -> list[SectionInfo]:
    """Return the sections of a JSON Schema of scenarios in the order of tabs, and in each tab by rank."""
    properties, required = schema["properties"], schema.get("required", ())
    rows = []
    for key, node in properties.items():
        tab, rank = node.get(TAB, (OTHER, 0))
        place = list(TABS).index(tab)
        rows.append((place, rank, SectionInfo(key, tab, node.get("description", ""), key in required)))
    return [info for _, _, info in sorted(rows, key=lambda row: row[:2])]


def ranked(properties: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return the keys of a section in the order of their ranks."""
    return sorted(properties, key=lambda key: properties[key].get(TAB, ("", 0))[1])
