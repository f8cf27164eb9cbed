"""Report of a solver benchmark: an HTML page, one SVG per robot, and the data as JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from cdpr.analysis.bench.adversaries import ARM, BAND
from cdpr.analysis.bench.overview import overview
from cdpr.log.files import markup, replace_all
from cdpr.scene import colours
from cdpr.ui.report.pages.page import banner, figure, page, section, table
from cdpr.ui.report.text.bench import COLUMNS, MEANING, MISLED, OVERVIEW, Columns, cells, facts, overview_cells

ABOUT = """<h2>Measurements</h2>
<p>Each solver got the same problems: find tensions t with W t = wrench, within the limits, at random poses of a
robot in a box around its home, tilted by up to 10°, under its weight with a random force and moment of up to a fifth
of it; every fifth problem carries a payload besides. Whether a problem is feasible, and what the optimum of an
objective is, was decided by linear programs (HiGHS) and quadratic programs (DAQP). Every answer was judged from
outside: finite, balancing the wrench to a millionth, within the limits to a millionth of a newton. Problems within
round-off of the edge (a margin of less than 1e-7 of the largest limit) are not counted.</p>
<p>Jumps were looked for along smooth, feasible paths by halving the steepest steps; what lies between the samples may
have been missed. Times are wall time of one call from Python. Compare medians, and times of one run only: a
<em>pinv</em> is numpy's pseudo-inverse of a 6x8 matrix, called in between. A 99th percentile far from the median is
often the operating system's. All other figures are the same on every run.</p>"""

MISLEADING = f"""<h2>Adversarial problems</h2>
<p>Matrices with parallel, opposite, equal and nearly parallel columns, columns and rows of zeros, dependent rows and
arms of {ARM:g} m; cables exactly at a limit, locked, or with as little as 1e-12 of the largest tension between their
limits; largest tensions from 1e-3 to 1e6 N; a third of the wrenches out of reach, by a share of 1.5e-8 to 1. A compiled
solver's work space is filled with NaN, 1e30 or 0 before each call. No solver decides what is true: feasible problems
are made from a solution in dyadic rationals, so that they have it exactly, infeasible ones come with a certificate by
Farkas' lemma.</p>
<p>The band: a feasible problem counts where all limits could be narrowed by {BAND:g} of the largest tension. Those
nearer to the edge are feasible, too, and have a separate column, but a solver that calls one infeasible is not
called wrong. All infeasible ones count. An answer called OK is judged everywhere: it is bad if it leaves the wrench
unbalanced by a millionth, or the limits by a millionth of a newton, or of the largest tension where that is less than
1 N.</p>"""

CAPTION = (
    "Dots: median time of a call on feasible problems; the line reaches to the 99th percentile; logarithmic. Bars: "
    "share of the feasible problems with a valid answer, and share of the smooth paths on which the tensions jump (in "
    "brackets the largest jump)."
)


def write_bench(figures: Mapping[str, Any], folder: Path, force: bool = True) -> None:
    """Write bench.json, bench.html and one SVG per robot into `folder`, which is created if necessary.

    Args:
        figures: result of `cdpr.analysis.bench.run`.
        folder: output folder.
        force: replace existing files.

    Raises:
        PluginError: if matplotlib is missing; bench.json is written before.
        OutputError: if a file cannot be written.
    """
    files: dict[str, str | bytes] = {"bench.json": json.dumps(figures, indent=1, allow_nan=False) + "\n"}
    try:
        drawn = drawings(figures)
        pages = drawn | {"bench.html": render(figures, list(drawn.values()))}
        files |= {name: markup(text) for name, text in pages.items()}
    finally:
        replace_all(folder, files, force)


def drawings(figures: Mapping[str, Any]) -> dict[str, str]:
    """Return the SVG texts by file name, in the order of the robots."""
    from cdpr.ui.report.figures import bench as bench_plots
    from cdpr.ui.report.figures.canvas import inline_svg

    out = {}
    for k, robot in enumerate(figures["robots"], 1):
        svg = inline_svg(
            bench_plots.robot(robot), f"robot{k}", f"Tension solvers on the robot {robot['name']}", both=False
        )
        out[drawing_name(k, robot["name"])] = svg
    return out


def drawing_name(k: int, robot: str) -> str:
    """Return the file name of the drawing of the k-th robot."""
    return f"{k}_{re.sub(r'[^A-Za-z0-9_-]+', '_', robot)[:60]}.svg"


def render(figures: Mapping[str, Any], drawn: list[str]) -> str:
    """Return the page as HTML; `drawn` holds one SVG per robot."""
    robots = figures["robots"]
    links = {"about": "About", "overview": "Overview"}
    parts = [section("about", ABOUT), section("overview", _overview(figures))]
    for k, (robot, svg) in enumerate(zip(robots, drawn, strict=True), 1):
        name = escape(robot["name"])
        links[f"robot{k}"] = robot["name"]
        parts.append(section(f"robot{k}", f"<h2>{name}</h2>\n<p>{escape(facts(robot))}.</p>\n{_results(robot)}"))
        # On wider figures, letters would be larger than the page's text.
        drawing = f'<div style="max-width: 58rem">{colours.on_either_ground(svg)}</div>'
        parts.append(figure(f"figure{k}", f"{name}: time, coverage, jumps", drawing, CAPTION))
    if hard := figures.get("adversaries"):
        links["adversaries"] = "Adversarial problems"
        tables = (f"<h3>{escape(facts(robot))}</h3>\n{_results(robot, MISLED)}" for robot in hard)
        parts.append(section("adversaries", MISLEADING + "\n" + "\n".join(tables)))
    links["columns"] = "Columns"
    parts.append(section("columns", "<h2>Columns</h2>\n" + table(MEANING.items())))
    count = len(figures["solvers"])
    subtitle = f"{count} solver{'s' * (count != 1)}, {figures['poses']} problems a robot, seed {figures['seed']}"
    first = banner("warn", "Interrupted", ": incomplete measurement") if figures["interrupted"] else ""
    return page("Tension solvers compared", subtitle, first, links, parts)


def _overview(figures: Mapping[str, Any]) -> str:
    rows, notes = [], []
    for row in overview(dict(figures)):
        name = f"<code>{escape(row['name'])}</code>"
        found = overview_cells(row)
        if found:
            rows.append((name, *map(escape, found)))
        else:
            notes.append(f"<p>{name} was not tested: {escape(row['problem'])}</p>")
    versions = ", ".join(f"{escape(name)} {escape(version)}" for name, version in figures["versions"].items())
    return (
        "<h2>Over all robots</h2>\n<p>From the worst to the best robot; jumps, wrong and bad answers summed, those "
        "to problems made to mislead included.</p>\n"
        f"{table(rows, ('Solver', *OVERVIEW))}\n" + "\n".join([*notes, f"<p>Versions: {versions}</p>"])
    )


def _results(robot: Mapping[str, Any], columns: Columns = COLUMNS) -> str:
    rows, notes = [], []
    for row in robot["results"]:
        name = f"<code>{escape(row['solver'])}</code>"
        rows.append((name, *(map(escape, cells(row, columns) or ["-"] * len(columns)))))
        if row["outcome"] == "failed":
            notes.append(f"<p>{name} failed: {escape(row['detail'])}</p>")
    return f"{table(rows, ('Solver', *columns))}\n" + "\n".join(notes)
