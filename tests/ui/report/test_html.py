import json
import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import ROOT
from html_page import NAMESPACES, Page
from report_cases import CASES, diverged_run, infeasible_run, make_run
from spread import sampled

from cdpr.base.errors import OutputError
from cdpr.log import summary
from cdpr.log.event import Event
from cdpr.log.run import Run
from cdpr.scene import colours
from cdpr.ui.report.figures.canvas import inline_svg
from cdpr.ui.report.pages import run as run_page
from cdpr.ui.report.pages.page import style
from cdpr.ui.report.pages.run import drawings, player_data, render, write_report
from cdpr.ui.report.pages.still import still
from cdpr.ui.report.pages.tables import MOST_EVENTS, number
from cdpr.ui.report.player.data import block
from cdpr.ui.report.style import paired

HERE = ROOT / "tests" / "support"


def row(text: str, title: str) -> list[str]:
    """Cells of the row with this heading."""
    found = re.search(rf'<tr><th scope="row">{re.escape(title)}</th>(.*)</tr>', text)
    assert found, title
    return re.findall(r"<td[^>]*>(.*?)</td>", found[1])


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """For content beside the figures, which take a second and more to draw."""
    monkeypatch.setattr("cdpr.ui.report.pages.run.drawings", lambda run: [])


@cache
def rendered(case: str) -> str:
    """The page of one of the cases, drawn once for all its tests."""
    return render(CASES[case]())


# Seconds of drawing what hardly differs from the others, or has two hundred times their points.
SLOW = {
    "100000 rows",
    "interrupted",
    "12 cables",
    "noisy",
    "far limits",
    "two rows",
    "long names",
    "one row",
    "one cable",
}


@sampled(1, "case", [pytest.param(x, marks=pytest.mark.slow) if x in SLOW else x for x in CASES])
def test_the_page_and_its_figures_are_sound_and_need_nothing_else(case: str) -> None:
    run = CASES[case]()
    text = rendered(case)
    page = Page(text)
    assert len(page.ids) == len(set(page.ids))
    assert all(link.startswith("#") for link in page.links)
    assert {link[1:] for link in page.links} <= set(page.ids)
    assert {"iframe", "img", "link", "object", "base"}.isdisjoint(page.tags)
    assert page.tags.count("script") == (2 if len(run.rows) else 0)  # data and script
    block = re.search(r'<script type="application/json" id="data">(.*?)</script>', text)
    assert (block is not None) == bool(len(run.rows))
    rest = text if block is None else text.replace(block[1], re.sub('"bytes":"[^"]*"', "", block[1]))
    rest = re.sub(r"^ *//.*$|(?<=[;,{}]) // .*$", "", rest, flags=re.MULTILINE)  # comments of the script
    assert not re.search(r"fetch|XMLHttpRequest|WebSocket|sendBeacon|importScripts|\bimport\b", rest)
    for namespace in NAMESPACES:
        rest = rest.replace(f'="{namespace}"', "")
    assert not re.search(r"https?:|//[a-z]|@import|url\((?!#)", rest)
    figures = re.findall(r"<svg xmlns.*?</svg>(?=</div>)", text, re.DOTALL)
    if len(run.rows):
        assert len(figures) == len(drawings(run))
        figures.append(inline_svg(run.plot(), "overview", "Overview"))
    for figure in figures:
        root = ElementTree.fromstring(figure)
        assert root.get("aria-label")
        for path in root.iter("{http://www.w3.org/2000/svg}path"):
            assert "nan" not in path.get("d", "")
            assert "inf" not in path.get("d", "")


def test_every_figure_is_there_with_a_caption_and_in_the_navigation() -> None:
    run = CASES["plain"]()
    text = rendered("plain")
    page = Page(text)
    names = [drawing.name for drawing in drawings(run)]
    assert len(names) == 9
    assert text.count("<svg xmlns") == page.tags.count("figcaption") == 9
    for name in (*names, "Summary", "Run", "Events", "Cables", "Scenario"):
        assert name.lower() in page.ids
        assert f"#{name.lower()}" in page.links


@pytest.mark.usefixtures("no_figures")
def test_figures_of_the_summary_are_in_human_units() -> None:
    run = make_run()
    figures = run.summary()
    text = render(run)
    for title, key in (
        ("Position error (mm)", "position_error_m"),
        ("Orientation error (mrad)", "orientation_error_rad"),
    ):
        assert row(text, title) == [number(1e3 * figures[key][part]) for part in ("max", "rms", "final")]
    assert row(text, "Largest tension (N)") == [f"{figures['tension_N']['max']:.4g}"]
    assert row(text, "Smallest margin to a limit (N)") == ["0"]
    assert row(text, "Steps without valid tensions") == ["none"]
    assert row(text, "Work of cables; of external wrenches (J)") == ["235.4; 0"]
    assert row(text, "Unexplained energy; total exchange (J)")[0].endswith("; 235.4")
    assert row(text, "Samples; simulated time") == ["4001; 4 s"]
    assert row(text, "Keys not used") == ["<code>controller.kd</code>"]
    assert row(text, "Control step; physics step") == ["1 ms; 1 ms"]
    assert "numpy 2.4.6" in row(text, "Versions")[0]


@pytest.mark.usefixtures("no_figures")
def test_each_cable_has_its_limits_and_extremes() -> None:
    run = make_run()
    text = render(run)
    key = f'<span class="key paired" style="{paired(colours.CABLES[2])}" data-thing="cable:cable_3"></span>'
    tension, length = run.tension[:, 2], run.length[:, 2]
    ends = (20.0, 650.0, tension.min(), tension.max(), length.min(), length.max())
    assert row(text, f"{key}cable_3") == [number(x) for x in ends]


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("run", "mood", "words"),
    [
        (make_run(rows=9), "good", "Finished: reached 4 s"),
        (infeasible_run(), "warn", "Finished, but 200 of 4001 samples had no admissible tensions; at 1 of 4001"),
        (diverged_run(), "bad", "Diverged: stopped at 1.199 s"),
        (CASES["interrupted"](), "warn", "Interrupted"),
        (
            replace(make_run(rows=9), status="infeasible", message="at 2 s"),
            "bad",
            "Stopped as infeasible: at 2 s",
        ),
        (replace(make_run(rows=9), status="running", message=""), "warn", "Did not end"),
        (
            replace(make_run(rows=9), status="failed", message="the <engine> died"),
            "bad",
            "Failed: the <engine> died",
        ),
    ],
)
def test_the_banner_shows_the_status(run: Run, mood: str, words: str) -> None:
    text = render(run)
    banner = re.search(r'<p class="banner (\w+)".*</p>', text)
    assert banner
    assert banner[1] == mood
    assert words in Page(banner[0]).words


@pytest.mark.usefixtures("no_figures")
def test_events_are_listed_with_time_kind_and_text() -> None:
    text = render(infeasible_run())
    button = '<button type="button" class="at" data-time="{0}">{0}</button>'
    assert row(text, "1") == [
        f"{button.format(0.9)} to 1.1",
        "infeasible",
        "no tensions within the limits balance the wrench",
    ]
    assert row(text, "3") == [button.format(3.2), "note", "the platform came to rest"]
    assert row(text, "Steps without valid tensions") == ["200 infeasible, 1 not found"]


@pytest.mark.usefixtures("no_figures")
def test_thousands_of_events_do_not_bury_the_page() -> None:
    events = tuple(Event(0.001 * i, "infeasible", "again") for i in range(3000))
    text = render(replace(make_run(), events=events))
    assert text.count("<td>again</td>") == MOST_EVENTS
    assert "And 2800 more" in text


def test_all_that_comes_from_outside_is_escaped() -> None:
    bad = "<script>alert(1)</script>\"'&"
    run = make_run(rows=50, names=(bad, *(f"c{i}" for i in range(7))))
    names = dict.fromkeys(("scenario", "robot", "backend", "controller", "solver", "scenario_yaml"), bad)
    header = replace(run.header, **names, versions={bad: bad})
    run = replace(
        run,
        header=header,
        status=bad,
        message=bad,
        unused=(bad,),
        events=(Event(0.01, bad, bad),),
        timings={bad: 1.0},
    )
    text = render(run)
    page = Page(text)
    assert page.tags.count("script") == text.count("<script") == 2  # ours
    assert "&lt;" not in page.words  # escaped once
    assert page.words.count(bad) >= 14


@pytest.mark.usefixtures("no_figures")
def test_a_template_sign_in_a_name_is_only_a_sign() -> None:
    run = make_run(rows=9)
    text = render(replace(run, header=replace(run.header, scenario="$title {length} %s")))
    assert "<h1>$title {length} %s: report of a run</h1>" in text


def test_a_run_without_a_sample_has_a_report() -> None:
    text = render(CASES["no row"]())
    assert "The run has no sample." in text
    assert "<svg" not in text


@pytest.mark.usefixtures("no_figures")
def test_a_diverged_run_names_its_non_finite_values() -> None:
    assert row(render(diverged_run()), "Position error (mm)")[2] == "not finite"


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # as in `render`
@pytest.mark.parametrize("values", [(np.nan, np.nan), (np.inf, -np.inf), (1e308, -1e308), (1e308, 1.0)], ids=str)
def test_the_player_gets_only_finite_numbers(values: tuple[float, float]) -> None:
    run = make_run(rows=6)
    table = run.rows.copy()
    for k, value in enumerate(values):
        table[k::2, 1:] = value
    odd = replace(run, rows=table)
    assert json.loads(block(player_data(odd, drawings(odd))).split(">")[1].split("<")[0])
    plot = still(odd, None, "Robot")  # on paper, too: the anchors are there in any case
    assert not re.search(r"\b(nan|inf)\b", plot)


@pytest.mark.usefixtures("no_figures")
def test_wall_clock_times_are_in_one_row_only() -> None:
    fast, slow = (render(replace(make_run(rows=200), timings={"loop_s": s})).splitlines() for s in (0.1, 7.0))
    different = [a for a, b in zip(fast, slow, strict=True) if a != b]
    assert len(different) == 1
    assert "Wall clock" in different[0]
    assert "Wall clock" not in render(replace(make_run(rows=200), timings={}))


@pytest.mark.slow
def test_two_processes_write_the_same_bytes(tmp_path: Path) -> None:
    code = (
        "import sys, report_cases as cases; from cdpr.ui.report.pages.run import write_report;"
        "write_report(cases.infeasible_run(), sys.argv[1])"
    )
    here, there = tmp_path / "here", tmp_path / "there"
    write_report(infeasible_run(), here)
    environment = {**os.environ, "PYTHONHASHSEED": "1"}  # here there is none, or another
    subprocess.run([sys.executable, "-c", code, str(there)], cwd=HERE, env=environment, check=True)
    assert here.read_bytes() == there.read_bytes()


def test_the_file_is_small() -> None:
    assert len(CASES["plain"]().rows) == 4001
    assert len(rendered("plain").encode()) < 1_100_000


@pytest.mark.usefixtures("no_figures")
def test_a_page_counts_a_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Banner, reservations and tables use its figures; data of another run is computed separately."""
    run, counted = make_run(rows=20), []

    class Counting(summary.Accumulator):
        def __init__(self, *arguments: Any) -> None:
            counted.append(arguments)
            super().__init__(*arguments)

    monkeypatch.setattr(summary, "Accumulator", Counting)
    render(run)
    assert len(counted) == 1
    run.summary()["tension_N"]["max"] = math.inf  # the caller's own
    assert run.summary()["tension_N"]["max"] == run.tension.max()
    part = replace(run, rows=run.rows[:7])
    assert part.summary()["samples"] == 7


@pytest.mark.usefixtures("no_figures")
def test_a_folder_that_is_not_there_is_reported(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"nowhere.*No such file"):
        write_report(make_run(rows=2), tmp_path / "nowhere" / "report.html")


@pytest.mark.slow
def test_without_matplotlib_the_page_is_whole_and_for_plots_the_remedy_is_named(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "import report_cases as cases\n"
        "from cdpr.base.errors import PluginError\n"
        "from cdpr.ui.report.pages.run import write_report\n"
        "run = cases.make_run(rows=3)\n"
        "try:\n"
        "    run.plot()\n"
        "except PluginError as error:\n"
        "    assert \"pip install 'cdpr[plot]'\" in str(error), error\n"
        "else:\n"
        "    raise SystemExit('no PluginError')\n"
        "write_report(run, sys.argv[1])\n"
    )
    report = tmp_path / "report.html"
    command = [sys.executable, "-c", code, str(report)]
    run = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    text = report.read_text()
    assert 'id="viewer"' in text
    assert 'role="img" aria-label="Cable tensions"' in text


@pytest.mark.slow
def test_the_room_itself_is_light() -> None:
    code = "import sys, cdpr.ui.report.pages.run; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.25479, "0.2548"),
        (-3.0, "−3"),
        (20000.0, "20000"),
        (1e-12, "1e−12"),
        (1e9, "1e+09"),
        (float("nan"), "not finite"),
    ],
)
def test_numbers_are_short(value: float, text: str) -> None:
    assert number(value) == text


def test_figures_have_their_colours_on_either_ground():
    """On a dark background the page provides the colours of a figure, and no colour for a light one remains."""
    text = inline_svg(make_run(rows=100).plot(), "overview", "Overview")
    asked = dict(re.findall(r"var\(--of-([0-9a-f]{6}), (#[0-9a-f]{6})\)", text))
    assert {colours.INK.light, colours.GROUND.light, colours.CABLES[0].light} <= set(asked.values())
    for name, light in asked.items():
        assert light == f"#{name}"
        assert f" --of-{name}: {colours.DARK[light]};" in style()
    assert not re.search(r": #[0-9a-f]{6}", text)
    assert "var(" not in make_run(rows=100).plot()._repr_svg_()


def test_no_colour_for_light_ground_has_two_for_dark():
    pairs = [value for value in vars(colours).values() if isinstance(value, colours.Pair)]
    assert all(colours.DARK[pair.light] == pair.dark for pair in [*pairs, *colours.CABLES, *colours.AXES])


@pytest.mark.slow
def test_a_section_is_one_entry_of_a_table(monkeypatch):
    monkeypatch.setitem(run_page.SECTIONS, "Weather", lambda run: f"<p>{run.status} in the rain</p>")
    page = Page(render(make_run()))
    assert "#weather" in page.links
    assert "finished in the rain" in page.words
