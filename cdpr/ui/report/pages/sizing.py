"""Report of a sizing, which prints on one sheet."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from cdpr.ui.report.pages.page import banner, page, section, table
from cdpr.ui.report.text.sizing import TABLES, cells, duties


def render_sizing(figures: Mapping[str, Any]) -> str:
    """Return the result of `Sizing.plain` as an HTML page."""
    sound = not any(each["infeasible"] or each["exceeded"] for each in figures["duties"])
    words = "All duties are within the robot's limits" if sound else "Some duties exceed the robot's limits"
    parts = []
    links = {}
    for key, (title, columns) in TABLES.items():
        head, *rows = [tuple(escape(cell) for cell in row) for row in cells(figures, columns)]
        if len(head) > 1:
            links[key] = title
            parts.append(section(key, f"<h2>{title}</h2>\n{table(rows, head)}"))
    parts.append(section("duties", f"<h2>Duties</h2>\n<pre>{escape(chr(10).join(duties(figures)))}</pre>"))
    title = f"{figures['robot']}: requirements on its cables"
    subtitle = f"Breaking load {figures['safety']:g} times the largest tension"
    links["duties"] = "Duties"
    return page(title, subtitle, banner("good" if sound else "warn", words), links, parts)
