"""Report of a study: an HTML page with small multiples, a player of some cases, and the table."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

from cdpr.analysis.study import Results
from cdpr.analysis.study.plan import Grid
from cdpr.log.files import replace_markup
from cdpr.ui.report.figures.study import multiples
from cdpr.ui.report.figures.study_layout import Layout, layouts
from cdpr.ui.report.pages.page import banner, figure, hall, page, section, table
from cdpr.ui.report.pages.study_cases import account, choose, player
from cdpr.ui.report.pages.study_spread import spread_section
from cdpr.ui.report.text.study import Figure, Record, cells, figures_of, label_text, value

MOST_ROWS = 1000  # of the table on the page
MOST_FIGURES = 24
DOTS = 12_000  # in all figures together
FEW_ROWS = 12  # rows of a table that is shown unfolded


class PageFigure(NamedTuple):
    """Figure of the page."""

    key: str
    layout: Layout
    what: Figure


def write_study(results: Results, path: Path) -> None:
    """Write the page.

    Raises:
        OutputError: if the file cannot be written.
    """
    replace_markup(path, render(results))


def render(results: Results) -> str:
    """Return the page as HTML."""
    study, records = results.study, results.table.records()
    links = {"about": "About"}
    parts = [section("about", _about(results))]
    if spread := spread_section(results):
        links["spread"] = "Mean and spread"
        parts.append(section("spread", spread))
    blocks = [[record for record in records if record.get("block") == grid.name] for grid in study.blocks]
    pairs = zip(study.blocks, blocks, strict=True)
    wanted = [_wanted(grid, inside, f"block{k}") for k, (grid, inside) in enumerate(pairs, 1)]
    count = sum(map(len, wanted))
    dots, left = DOTS // max(min(count, MOST_FIGURES), 1), MOST_FIGURES
    for k, (grid, inside, figures) in enumerate(zip(study.blocks, blocks, wanted, strict=True), 1):
        if grid.name is not None:
            links[f"block{k}"] = grid.name
            parts.append(section(f"block{k}", f"<h2>{escape(grid.name)}</h2>\n<p>{len(inside)} cases.</p>"))
        if figures[:left]:
            parts.append(hall([_drawn(inside, one, dots) for one in figures[:left]], "wide cards"))
            if grid.name is None:
                links[figures[0].key] = "Figures"
        left = max(0, left - len(figures))
    if count > MOST_FIGURES:
        rest = count - MOST_FIGURES
        parts.append(section("rest", f"<p>{rest} more figures are left out: table.csv has their numbers.</p>"))
    shown, notes = choose(results)
    data = None
    if shown:
        data, playing = player(shown)
        parts.append(playing)
        links["robot"] = "Robot"
    if shown or notes:
        links["shown"] = "Cases"
        parts.append(section("shown", f"<h2>Playback</h2>\n{account(shown, notes)}"))
    links["table"] = "Table"
    parts.append(section("table", _table(results)))
    mood = "bad" if results.exit_code else "warn" if results.strained else "good"
    first = banner(mood, f"{len(records)} cases", f": {escape(results.summary_text)}")
    return page(study.name, "a study by cdpr", first, links, parts, data)


def _about(results: Results) -> str:
    """Return the axes, the versions and an explanation of the figures."""
    study = results.study
    rows = []
    for grid in study.blocks:
        for axis, points in zip(grid.axes, grid.columns, strict=True):
            for leaf in axis.leaves():
                places = dict.fromkeys(label_text(point.labels[leaf.label]) for point in points)
                some = list(places) if len(places) <= 12 else [*list(places)[:5], "...", list(places)[-1]]
                rows.append((f"<code>{escape(leaf.label)}</code>", str(len(places)), escape(", ".join(some))))
    scenarios = dict.fromkeys(os.path.normpath(grid.scenario.source) for grid in study.blocks)
    versions = {f"{name} {version}" for row in results.rows.values() for name, version in row.versions.items()}
    return (
        f"<h2>Varied keys</h2>\n{table(dict.fromkeys(rows), ('Axis', 'Number', 'Values'), numeric=False)}\n"
        f"<p>Scenario: {escape(', '.join(scenarios))}. "
        f"Versions: {escape(', '.join(sorted(versions)))}.</p>\n"
        "<p>A dot is a run. Runs that differ only in axes not plotted are summarised by their median (dot) and range "
        "(line). If they differ only in their seed, the dot is their mean, the thick line one standard deviation, and "
        "the thin line the 95 % band. Crosses at the top are runs without a result: they diverged, failed, died or "
        "hung.</p>"
    )


def _wanted(grid: Grid, records: Sequence[Record], key: str) -> list[PageFigure]:
    """Return the figures of a part of a study, except those of quantities that are always zero."""
    return [
        PageFigure(f"{key}figure{i}_{k}", layout, what)
        for i, layout in enumerate(layouts(grid), 1)
        for k, what in enumerate(figures_of(records), 1)
        if any(value(record, what) for record in records)
    ]


def _drawn(records: Sequence[Record], wanted: PageFigure, dots: int) -> str:
    key, layout, what = wanted
    svg = multiples(layout, records, what, dots).markup(what.title)
    return figure(key, escape(what.title), svg, escape(_caption(layout)), kind="wide broad" if layout.panels else "")


def _caption(layout: Layout) -> str:
    lines = f"; lines: {layout.line}" if layout.line else ""
    panels = f"; panels: {', '.join(layout.panels)}" if layout.panels else ""
    seeds = "; mean and spread over the seeds" if layout.seeds else ""
    return f"Over {layout.x}{lines}{panels}{seeds}."


def _table(results: Results) -> str:
    rows = []
    records = results.table.records()
    figures = figures_of(records)
    messages = ["Message"] if any(record["message"] for record in records) else []
    for case, record in zip(results.study.cases, records, strict=True):
        labels, found = cells(results.table.axes, record, figures)
        block = [case.block] if case.block is not None else []
        message = [str(record["message"] or "")] if messages else []
        rows.append(tuple(map(escape, (case.id, *block, *labels, *found, *message))))
        if len(rows) == MOST_ROWS:
            break
    blocks = ["Block"] if any(case.block is not None for case in results.study.cases) else []
    titles = ("Case", *blocks, *results.table.axes, "Status", *(what.title for what in figures), *messages)
    more = len(results.study.cases) - len(rows)
    rest = f"\n<p>And {more} more in table.csv.</p>" if more else ""
    shown = tuple(escape(title).replace(".", ".<wbr>") for title in titles)  # allow line breaks in key names
    inside = f"{table(rows, shown)}{rest}"
    fold = " open" if len(rows) <= FEW_ROWS else ""
    return f"<h2>All cases</h2>\n<details{fold}><summary>{len(rows)} rows</summary>\n{inside}</details>"
