"""Sections of scenario files in the order of their tabs, for the window, the documentation and the help of commands.

A field of `ScenarioSection` declares its tab with `json_schema_extra=tab(...)`; everything else comes from its
description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cdpr.base.fields import HOME, TAB

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
        required: True if every file must contain it.
    """

    key: str
    tab: str
    text: str
    required: bool


def sections_of(schema: Mapping[str, Any]) -> list[SectionInfo]:
    """Return the sections of a JSON Schema of scenarios in the order of tabs, and in each tab by rank."""
    properties, required = schema["properties"], required_keys(schema)
    rows = []
    for key, node in properties.items():
        tab, rank = node.get(TAB, (OTHER, 0))
        place = list(TABS).index(tab)
        rows.append((place, rank, SectionInfo(key, tab, node.get("description", ""), key in required)))
    return [info for _, _, info in sorted(rows, key=lambda row: row[:2])]


def required_keys(schema: Mapping[str, Any]) -> list[str]:
    """Return the required keys of a section's JSON Schema, except those that the robot's home replaces."""
    return [key for key in schema.get("required", ()) if HOME not in schema["properties"][key]]


def ranked(properties: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return the keys of a section in the order of their ranks."""
    return sorted(properties, key=lambda key: properties[key].get(TAB, ("", 0))[1])
