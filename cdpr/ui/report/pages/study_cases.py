"""Cases of a study that the player shows: their selection and their overlaid runs."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from cdpr.analysis.jobs.folder import RESULTS
from cdpr.analysis.study import Results, StudyCase
from cdpr.analysis.study.folder import RUNS_NAME
from cdpr.base.errors import CdprError
from cdpr.log.mcap_file import LOG_NAME
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.ui.report.pages.page import figure, panels, swatch, table, theatre
from cdpr.ui.report.pages.still import still_panels
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.assets import viewer
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene_of_run
from cdpr.ui.report.plots.cases import overlay
from cdpr.ui.report.plots.overlay import span
from cdpr.ui.report.style import overlaid_looks, shorten
from cdpr.ui.report.text.study import FIGURES, Figure, Record, label_text, value

MOST = 4  # cases; more overlaid runs are indistinguishable
# Criteria of the selection among many cases: the case with the least or the greatest value.
ERROR, LARGEST, SMALLEST = FIGURES[0], FIGURES[3], FIGURES[4]
BY = ((ERROR, "greatest"), (ERROR, "least"), (LARGEST, "greatest"), (SMALLEST, "least"))

SPACE = (
    "The runs of some cases over one another, each in its colour; solid the platform of the first one. "
    "Its desired pose and path are drawn, too."
)
OVER = "Norms of the errors, and the largest and the smallest of the tensions in the cables of each run."


class SelectedCase(NamedTuple):
    """Selected case."""

    case: StudyCase
    why: str
    run: Run


def choose(results: Results) -> tuple[list[SelectedCase], list[str]]:
    """Return the cases that the player shows, and remarks on cases that it cannot show."""
    records = dict(zip((case.id for case in results.study.cases), results.table.records(), strict=True))
    logged = [case for case in results.study.cases if (_folder(results, case) / LOG_NAME).is_file()]
    sound = [case for case in logged if results.rows[case.id].status in RESULTS]
    shown: list[SelectedCase] = []
    notes = list(_notes(results, len(logged), len(sound)))
    for case, why in _wanted(sound, records):
        if len(shown) == MOST:
            break
        try:
            with warnings.catch_warnings(record=True) as cut:
                warnings.simplefilter("always")
                run = load_run(_folder(results, case))
        except CdprError as error:
            notes.append(f"Case {case.id} cannot be shown: {error}.")
            continue
        if not len(run.rows):
            notes.append(f"Case {case.id} cannot be shown: its run has no sample.")
            continue
        notes += [f"Case {case.id}: {warning.message}." for warning in cut]
        shown.append(SelectedCase(case, why, run))
    return shown, notes


def _folder(results: Results, case: StudyCase) -> Any:
    return results.folder / RUNS_NAME / case.id


def _notes(results: Results, logged: int, sound: int) -> Iterator[str]:
    count = len(results.study.cases)
    if not logged:
        kept = {"none": "of no case", "failed": "of cases that did not finish", "all": "of all cases"}
        yield f"No case has a log: the study keeps logs {kept[results.study.keep]} (its key `keep`)."
    elif logged < count:
        yield f"{count - logged} of {count} cases have no log."
    if sound < logged:
        yield f"{logged - sound} with a log failed, crashed or hung: see the table."


def _wanted(cases: Sequence[StudyCase], records: Mapping[str, Record]) -> Iterator[tuple[StudyCase, str]]:
    """Yield cases and the reason to show each, most informative first; all cases if there are few."""
    if len(cases) <= MOST:
        yield from ((case, "") for case in cases)
        return
    seen: set[str] = set()
    good, bad = ([case for case in cases if (records[case.id]["status"] == "finished") is so] for so in (True, False))
    offers = [_extreme(good, records, figure, word) for figure, word in BY]
    offers.insert(2, (bad[0], f"the first that is {records[bad[0].id]['status']}") if bad else None)
    for offer in (*offers, *((case, "the next one") for case in cases)):
        if offer is not None and offer[0].id not in seen:
            seen.add(offer[0].id)
            yield offer


def _extreme(
    cases: Sequence[StudyCase], records: Mapping[str, Record], figure: Figure, word: str
) -> tuple[StudyCase, str] | None:
    """Return the case with the least or greatest value, the first of equals; None if no case has a value."""
    found = [(number, case) for case in cases if (number := value(records[case.id], figure)) is not None]
    if not found:
        return None
    _, case = (min if word == "least" else max)(found, key=lambda pair: pair[0])
    return case, f"{word} of all: {figure.title[0].lower()}{figure.title[1:]}"


def names(cases: Sequence[StudyCase]) -> list[str]:
    """Return numbered names of cases: their values on the axes on which they differ."""
    axes = list(dict.fromkeys(axis for case in cases for axis in case.labels))
    differ = [axis for axis in axes if len({case.labels.get(axis) for case in cases}) > 1]
    found: list[str] = []
    for case in cases:
        parts = [case.block] if case.block and len({each.block for each in cases}) > 1 else []
        for axis in differ:
            text = label_text(case.labels.get(axis))
            parts.append(text if isinstance(case.labels.get(axis), str) else f"{axis.rpartition('.')[2]} {text}")
        found.append(f"{len(found) + 1}: {shorten(', '.join(parts) or case.id, 44)}")
    return found


def player(shown: Sequence[SelectedCase]) -> tuple[dict[str, Any], str]:
    """Return the player data, and the player's part of the page."""
    arrays = Arrays()
    runs = dict(zip(names([each.case for each in shown]), (each.run for each in shown), strict=True))
    looks = overlaid_looks("case", list(runs))
    scenes = [scene_of_run(run, arrays, name, looks[name]) for name, run in runs.items()]
    ends = [span(run) for run in runs.values()]
    whole = (min(start for start, _ in ends), max(stop for _, stop in ends))
    drawn = overlay(runs)
    data = page_data(None, scenes, {"cases": drawn}, arrays, whole)
    title = "Some cases over one another"
    gallery = figure("cases", title, still_panels(drawn, whole, (), title), OVER, live=panels("cases"))
    return data, theatre(figure("robot", "Robot", "", SPACE, live=viewer(data)), [gallery])


def account(shown: Sequence[SelectedCase], notes: Sequence[str]) -> str:
    """Return the table of shown cases with reasons, and the remarks, as HTML."""
    rows = []
    looks = overlaid_looks("case", names([each.case for each in shown]))
    for (name, look), each in zip(looks.items(), shown, strict=True):
        rows.append((swatch(look) + escape(each.case.id), escape(name), escape(each.run.status), escape(each.why)))
    found = ""
    if rows:
        inside = table(rows, ("Case", "Difference", "Status", "Reason"), numeric=False)
        found = f"<details><summary>Cases with playback</summary>\n{inside}</details>\n"
    return found + "\n".join(f"<p>{escape(text)}</p>" for text in notes)
