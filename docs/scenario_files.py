"""Write the table of docs/scenario_files.md. Run: python docs/scenario_files.py. A test holds the page to it."""

from __future__ import annotations

from pathlib import Path

from marked import rewritten, table

from cdpr.config.describe import json_schema
from cdpr.scenario import schema
from cdpr.scenario.sections import TABS, sections_of

PAGE = Path(__file__).parent / "scenario_files.md"


def sections_table() -> str:
    """Return the table of sections, in the order of the window's tabs."""
    rows = sections_of(json_schema(schema.ScenarioSection))
    titles = ("key", "tab", "required", "description")
    return table(titles, ((f"`{row.key}`", TABS[row.tab], "yes" if row.required else "", row.text) for row in rows))


def updated(text: str) -> str:
    """The page with its table written anew."""
    return rewritten(text, {"sections": sections_table})


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text()))
