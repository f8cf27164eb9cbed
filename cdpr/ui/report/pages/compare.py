"""Report of a comparison: compare.json, and an HTML page with overlaid runs and their differences."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cdpr.analysis.compare.differences import QUANTITIES
from cdpr.analysis.compare.job import RESERVED
from cdpr.log.files import make_folder, replace, replace_markup
from cdpr.ui.report.pages.page import banner, figure, hall, page, panels, section, swatch, table, theatre
from cdpr.ui.report.pages.still import still
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.assets import viewer
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene_of_run
from cdpr.ui.report.plots import compare as plots
from cdpr.ui.report.style import overlaid_looks
from cdpr.ui.report.text.aligned import number
from cdpr.ui.report.text.compare import (
    DIFFERENT_SOLVERS,
    ORDER_TITLES,
    among,
    check_cells,
    different_solvers,
    notes,
    order_cells,
    order_reasons,
    outcome,
    subject,
    truth_error,
    worst,
)

if TYPE_CHECKING:
    from cdpr.analysis.compare.comparison import Group
    from cdpr.analysis.compare.job import Comparison

Figures = Mapping[str, Any]

ABOUT_SPACE = "The runs with the first solver over one another, each in its colour; the first is the reference."

BANNERS = {
    True: ("good", "The engines agree"),
    False: ("bad", "The engines disagree"),
    None: ("warn", "Not judged"),
}

ABOUT = """<h2>How engines are judged</h2>
<p>All run the same closed loop; differences are those to the judge, the engine of highest declared order. How large
they may be is known, not guessed. An engine whose scheme the judge offers, too, is held against the judge running that
scheme with the same step: two programs for one scheme differ by round-off alone, so that what lies <em>beyond the
scheme</em> is a fault of the adapter or of the engine. An engine with another scheme runs with three steps;
extrapolated to a vanishing step it must give the judge's solution, within the judge's own estimated error. A tension
solver that may jump between several answers leaves the pose to be judged. Times inform and are never judged.</p>"""


def write_comparison(result: Comparison, folder: Path) -> None:
    """Write compare.json and compare.html into `folder`, which is created if necessary.

    Raises:
        OutputError: if a file cannot be written.
    """
    make_folder(folder)
    replace(folder / "compare.json", json.dumps(result.figures, indent=1, allow_nan=False) + "\n")
    replace_markup(folder / "compare.html", render(result))
    with contextlib.suppress(OSError):
        (folder / RESERVED).unlink(missing_ok=True)


def render(result: Comparison) -> str:
    """Return the page as HTML."""
    figures, looks = result.figures, engine_looks(result.figures)
    mood, text = BANNERS[figures["agrees"]]
    links = {"verdict": "Verdict"}
    parts = [section("verdict", _verdict(result, looks))]
    data = player_data(result)
    scene = figure("robot", "Robot", "", ABOUT_SPACE, live=viewer(data)) if data else ""
    for k, (group, found) in enumerate(zip(result.groups, figures["groups"], strict=True), 1):
        shown = _drawings(group, k, figures["judge"]["backend"], looks)
        if shown:
            links |= {"robot": "Robot"} if scene else {}
            parts.append(theatre(scene, shown) if scene else hall(shown, "cards"))
            scene = ""
            links[f"differences{k}"] = "Differences"
        links[f"solver{k}"] = f"Solver {group.solver}"
        parts.append(section(f"solver{k}", f"<h2>Solver {escape(group.solver)}</h2>\n{_engines(found)}"))
        if found["orders"]:
            rows = [tuple(map(escape, order_cells(row))) for row in found["orders"]]
            orders = table(rows, ("Engine", *ORDER_TITLES[1:2], "", *ORDER_TITLES[3:]))
            texts = (*order_reasons(found), *truth_error(found))
            orders += "".join(f"<p>{escape(text[0].upper() + text[1:])}.</p>" for text in texts)
            parts.append(section(f"orders{k}", f"<h2>Measured orders</h2>\n{ORDERS}\n{orders}"))
    links["about"] = "About"
    parts.append(section("about", ABOUT))
    links["versions"] = "Versions"
    versions = [(escape(name), escape(version)) for name, version in figures["versions"].items()]
    absent = "".join(f"<p>{escape(name)}: {escape(reason)}</p>" for name, reason in figures["absent"].items())
    parts.append(section("versions", f"<h2>Versions</h2>\n{table(versions)}{absent}"))
    title = f"{figures['scenario']}: {'solvers' if different_solvers(figures) else 'engines'} compared"
    return page(title, subject(figures), banner(mood, text, _why(figures)), links, parts, data)


ORDERS = (
    "<p>How the root mean square of the error in pose (angles times the characteristic length) falls with the physics "
    "step, the control period kept. The truth is the judge's scheme of highest order at a quarter of the finest step. "
    "Where errors would drown in round-off, the loop is closed less often.</p>"
)


def _why(figures: Figures) -> str:
    """Return the reasons of a disagreement or of a missing verdict, as HTML."""
    reasons = []
    for group in figures["groups"]:
        reasons += [group["problem"]] if group["problem"] else []
        reasons += [
            f"{row['label']} with {group['solver']}: {row['reason']}"
            for row in group["engines"]
            if row["outcome"] in ("disagrees", "failed")
        ]
        reasons += order_reasons(group, failed=True)
        if figures["agrees"] is None:
            reasons += [DIFFERENT_SOLVERS] if different_solvers(figures) else []
            reasons += [_apart(row, figures["judge"]["backend"]) for row in group["engines"] if row["differences"]]
    return "".join(f"<br>{escape(reason)}" for reason in reasons)


def _apart(row: Figures, judge: str) -> str:
    """Return the largest differences between a run and the judge, for runs that are not judged."""
    most = [
        f"{number(found['max'])} {QUANTITIES[name].unit} in {QUANTITIES[name].title}"
        for name, found in row["differences"].items()
    ]
    return f"{row['label']} is never farther from {judge} than {', '.join(most)}"


def _engines(group: Figures) -> str:
    out = [f"<p>{escape(group['problem'])}</p>"] if group["problem"] else []
    for row in group["engines"]:
        out.append(f"<h3>{escape(row['label'])}</h3>\n<p>{escape(outcome(row))}</p>")
        if row["differences"]:
            titles = ("Difference", "largest", "rms", "at (s)", *JUDGED[row["standard"]])
            inside = f"{table(_rows(row), titles)}"
            out.append(f"<details><summary>All differences</summary>\n{inside}</details>")
        out += [f"<p>{escape(text[0].upper() + text[1:])}.</p>" for text in [*notes(row)]]
    out += [f"<p>{escape(text[0].upper() + text[1:])}.</p>" for text in among(group)]
    return "\n".join(out)


JUDGED = {"scheme": ("beyond its scheme", "allowed"), "order": ("limit (rms)", "allowed"), "none": ()}


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


def engine_looks(figures: Figures) -> dict[str, dict[str, Any]]:
    """Return the style of each engine on the page, by label; the judge is the first."""
    labels = [row["label"] for group in figures["groups"] for row in group["engines"]]
    return overlaid_looks("engine", list(dict.fromkeys([figures["judge"]["backend"], *labels])))


def _drawings(group: Group, k: int, judge: str, looks: plots.Looks) -> list[str]:
    """Return the figures of one solver's runs as HTML."""
    if not _drawable(group):
        return []
    assert group.judge is not None
    out = []
    for name, (title, panels_of, caption) in plots.drawings(group).items():
        at, drawn = f"{name}{k}", panels_of(group, judge, looks)
        out.append(figure(at, title, still(group.judge, drawn, title), caption, live=panels(at), kind="tall"))
    return out


def player_data(result: Comparison) -> dict[str, Any] | None:
    """Return the player data: the runs of the first solver in one scene, and all panels; None if there are no runs."""
    groups = [(k, group) for k, group in enumerate(result.groups, 1) if _drawable(group)]
    if not groups:
        return None
    arrays = Arrays()
    first = groups[0][1]
    assert first.judge is not None
    others = [(row.label, row.run) for row in first.rows if row.run is not None and len(row.run.rows)]
    judge, looks = result.figures["judge"]["backend"], engine_looks(result.figures)
    runs = [(judge, first.judge), *others]
    scenes = [scene_of_run(run, arrays, label, looks[label]) for label, run in runs]
    shown = {}
    for k, group in groups:
        for name, (_, panels_of, _) in plots.drawings(group).items():
            shown[f"{name}{k}"] = panels_of(group, judge, looks)
    return page_data(first.judge, scenes, shown, arrays)


def _drawable(group: Group) -> bool:
    return group.judge is not None and len(group.judge.rows) > 0 and any(row.run is not None for row in group.rows)


def _verdict(result: Comparison, looks: plots.Looks) -> str:
    """Return a table with one row per engine and its largest ratio of difference to bound."""
    rows, judge = [], result.figures["judge"]["backend"]
    for group, found in zip(result.groups, result.figures["groups"], strict=True):
        if group.judge is not None:
            rows.append((judge, group.judge.header.solver, "judge", "", f"{len(group.judge.rows)}"))
        for row, known in zip(group.rows, found["engines"], strict=True):
            ratio, quantity = worst(known) or (None, "")
            share = "not judged" if ratio is None else f"{number(ratio)} ({quantity})"
            solver = found["solver"] if row.run is None else row.run.header.solver
            rows.append((row.label, solver, known["outcome"], share, f"{known['samples']}"))
    titles = ("Engine", "Solver", "Verdict", "Largest ratio to the tolerance (1 is allowed)", "Samples")
    marked = [(swatch(looks[label]) + escape(label), *map(escape, rest)) for label, *rest in rows]
    return f"<h2>Verdict</h2>\n{table(marked, titles, numeric=False)}"
