"""The report of a comparison: compare.json, and one HTML page with overlays and differences."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cdpr.compare.differences import QUANTITIES
from cdpr.log.files import make_folder, replace
from cdpr.report.pages.page import figure, page, section, table
from cdpr.report.text.aligned import number
from cdpr.report.text.compare import (
    ORDER_TITLES,
    among,
    check_cells,
    notes,
    order_cells,
    outcome,
    subject,
    wrong_orders,
)

if TYPE_CHECKING:
    from cdpr.compare.comparison import Group
    from cdpr.compare.job import Comparison

Figures = Mapping[str, Any]

BANNERS = {
    True: ("good", "The engines agree"),
    False: ("bad", "The engines disagree"),
    None: ("warn", "Nothing could be judged"),
}

ABOUT = """<h2>How engines are judged</h2>
<p>All run the same closed loop; differences are those to the judge, the engine of highest declared order. How large
they may be is known, not guessed. An engine whose scheme the judge offers, too, is held against the judge running that
scheme with the same step: two programs for one scheme differ by round-off alone, so that what lies <em>beyond the
scheme</em> is a fault of the adapter or of the engine. Of an engine with a scheme of its own, half the step must divide
the distance to the judge by two to the power of its order. A tension solver that may jump between several answers
leaves the pose to be judged. Times inform and are never judged.</p>"""


def write_comparison(result: Comparison, folder: Path) -> None:
    """Write compare.json and compare.html into `folder`, made if need be.

    Raises PluginError without matplotlib, after compare.json is written, and OutputError where a file cannot be
    written.
    """
    make_folder(folder)
    replace(folder / "compare.json", json.dumps(result.figures, indent=1, allow_nan=False) + "\n")
    replace(folder / "compare.html", render(result).encode(errors="xmlcharrefreplace"))


def render(result: Comparison) -> str:
    """Return the page as HTML."""
    figures = result.figures
    mood, text = BANNERS[figures["agrees"]]
    links = {"about": "About"}
    parts = []
    for k, (group, found) in enumerate(zip(result.groups, figures["groups"], strict=True), 1):
        links[f"solver{k}"] = f"Solver {group.solver}"
        parts.append(section(f"solver{k}", f"<h2>Solver {escape(group.solver)}</h2>\n{_engines(found)}"))
        if found["orders"]:
            rows = [tuple(map(escape, order_cells(row))) for row in found["orders"]]
            orders = table(rows, ("Engine", *ORDER_TITLES[1:2], "", *ORDER_TITLES[3:]))
            parts.append(section(f"orders{k}", f"<h2>Measured orders</h2>\n{ORDERS}\n{orders}"))
        parts += _drawings(group, k)
    links["versions"] = "Versions"
    versions = [(escape(name), escape(version)) for name, version in figures["versions"].items()]
    absent = "".join(f"<p>{escape(name)}: {escape(reason)}</p>" for name, reason in figures["absent"].items())
    parts.append(section("versions", f"<h2>Versions</h2>\n{table(versions)}{absent}"))
    banner = f'<p class="banner {mood}" role="status"><strong>{text}</strong>{_why(figures)}</p>'
    title = f"{figures['scenario']}: engines compared"
    return page(title, subject(figures), banner, links, [*parts[:1], section("about", ABOUT), *parts[1:]])


ORDERS = (
    "<p>How the root mean square of the error in pose (angles times the characteristic length) falls with the physics "
    "step, the control period kept. The truth is the judge's scheme of highest order at a quarter of the finest step. "
    "Where errors would drown in round-off, the loop is closed less often.</p>"
)


def _why(figures: Figures) -> str:
    """Who disagrees, and why."""
    reasons = []
    for group in figures["groups"]:
        reasons += [group["problem"]] if group["problem"] else []
        reasons += [
            f"{row['label']} with {group['solver']}: {row['reason']}"
            for row in group["engines"]
            if row["outcome"] in ("disagrees", "failed")
        ]
        reasons += wrong_orders(group)
    return "".join(f"<br>{escape(reason)}" for reason in reasons)


def _engines(group: Figures) -> str:
    out = [f"<p>{escape(group['problem'])}</p>"] if group["problem"] else []
    for row in group["engines"]:
        out.append(f"<h3>{escape(row['label'])}</h3>\n<p>{escape(outcome(row))}</p>")
        if row["differences"]:
            titles = ("Difference", "largest", "rms", "at (s)", *JUDGED[row["standard"]])
            out.append(f'<div class="scroll">{table(_rows(row), titles)}</div>')
        out += [f"<p>{escape(text[0].upper() + text[1:])}.</p>" for text in [*notes(row)]]
    out += [f"<p>{escape(text[0].upper() + text[1:])}.</p>" for text in among(group)]
    return "\n".join(out)


JUDGED = {"scheme": ("beyond its scheme", "allowed"), "order": ("divided by half the step", "allowed"), "none": ()}


def _rows(row: Figures) -> list[tuple[str, ...]]:
    checks = {check["quantity"]: check for check in row["checks"]}
    rows = []
    for name, found in row["differences"].items():
        quantity = QUANTITIES[name]
        cells = [f"{quantity.title} ({quantity.unit})", number(found["max"]), number(found["rms"])]
        cells.append(f"{found['time']:.6g}")
        if row["standard"] != "none":
            cells += check_cells(checks[name]) if name in checks else ["", "not judged"]
        rows.append(tuple(map(escape, cells)))
    return rows


def _drawings(group: Group, k: int) -> list[str]:
    """The figures of one solver's runs."""
    from cdpr.report.figures import compare as compare_plots
    from cdpr.report.figures.canvas import inline_svg

    if group.judge is None or not any(row.run is not None for row in group.rows):
        return []
    out = []
    for name, (title, draw, caption) in compare_plots.drawings(group).items():
        key = f"{name}{k}"
        out.append(figure(key, title, inline_svg(draw(group), key, title), caption))
    return out
