"""Figures for print: what is drawn by name, how wide and how large, and fonts that any publisher takes."""

from __future__ import annotations

import re
import zlib
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from command_line import cdpr_here
from report_cases import CASES, make_run
from spread import sampled

import cdpr
from cdpr.base.errors import CdprError
from cdpr.log.event import Event
from cdpr.ui.report.plots.pick import numbers
from cdpr.ui.report.style import CABLES

SVG = "{http://www.w3.org/2000/svg}"
POINT = 1.0 / 72.0  # in


@pytest.fixture(scope="module")
def run():
    made = make_run(rows=400)
    return replace(made, events=(Event(0.1, "push", "a push"), Event(0.3, "push", "another")))


def saved(figure, folder, kind):
    path = folder / f"figure.{kind}"
    figure.savefig(path)
    return path.read_bytes()


def font_types(pdf: bytes) -> set[bytes]:
    """Kinds of the fonts in a PDF, those in compressed objects, too."""
    parts = [pdf]
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL):
        try:
            parts.append(zlib.decompress(stream))
        except zlib.error:
            continue
    return {kind for part in parts for kind in re.findall(rb"/Subtype\s*/(Type[0-9][A-Z]?|CIDFontType\w+)\b", part)}


@pytest.mark.slow
def test_a_pdf_embeds_its_fonts_as_truetype(run, tmp_path):
    found = font_types(saved(run.plot("tension", "position_error", width="ieee"), tmp_path, "pdf"))
    assert b"CIDFontType2" in found  # TrueType outlines
    assert not found & {b"Type3", b"Type1"}


@pytest.mark.slow
def test_the_check_of_fonts_sees_type_3(run, tmp_path):
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context({"pdf.fonttype": 3}):
        Figure.savefig(run.plot("tension"), tmp_path / "figure.pdf")
    assert b"Type3" in font_types((tmp_path / "figure.pdf").read_bytes())


def test_an_svg_has_outlines_for_letters(run, tmp_path):
    text = saved(run.plot("tension", "position_error", width="ieee"), tmp_path, "svg").decode()
    root = ElementTree.fromstring(text)
    assert list(root.iter(f"{SVG}text")) == []
    assert "font-family" not in text
    assert "cdpr" not in root.attrib.values()


@pytest.mark.slow
@sampled(lambda kind: kind == "svg", "kind", ["pdf", "svg", "png"])
def test_the_same_run_gives_the_same_bytes(run, tmp_path, kind, monkeypatch):
    first = saved(run.plot("tension", width="ieee"), tmp_path, kind)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert saved(run.plot("tension", width="ieee"), tmp_path, kind) == first
    assert not re.search(rb"CreationDate|<dc:date>", first)


@pytest.mark.parametrize(
    ("width", "inches"),
    [
        ("ieee", 3.5),
        ("ieee-wide", 7.16),
        (4.0, 4.0),
        ("88 mm", 88 / 25.4),
        ("8.8cm", 88 / 25.4),
        ("252pt", 3.5),
        ("3.5", 3.5),
    ],
)
def test_the_figure_has_the_requested_width(run, width, inches):
    assert run.plot("tension", "position", width=width).get_figwidth() == pytest.approx(inches)


@pytest.mark.slow
@sampled(1, ("width", "inches"), [("ieee", 3.5), ("ieee-wide", 7.16)])
def test_its_file_is_as_wide_as_the_figure(run, tmp_path, width, inches):
    figure = run.plot("tension", "position", width=width)
    (box,) = re.findall(rb"/MediaBox \[ ?0 0 ([0-9.]+) [0-9.]+ ?\]", saved(figure, tmp_path, "pdf"))
    assert float(box) * POINT == pytest.approx(inches, abs=1e-3)


@pytest.mark.parametrize("width", [True, 0, -3.5, 1.0, 1000, np.nan, "iee", "", "3.5 inch", "88 km", "３in"])
def test_an_invalid_width_is_reported(run, width):
    with pytest.raises(CdprError, match="width must be ieee, ieee-wide, a number of inches from 2 to 40") as told:
        run.plot("tension", width=width)
    assert "\n" not in str(told.value)


@pytest.mark.slow
def test_letters_are_of_8_pt_and_nothing_leaves_the_figure(run):
    """Ticks, labels, legends and numbers of events, also where many cables have long names."""
    from matplotlib.text import Text

    for case in (run, CASES["long names"](), CASES["infeasible"]()):
        figure = case.plot("tension", "residual", width="ieee")
        figure.canvas.draw()
        width, height = figure.bbox.size
        texts = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
        assert {text.get_fontsize() for text in texts} == {8.0}
        boxes = [text.get_window_extent() for text in texts if text.get_window_extent().width]
        assert min(min(box.x0 for box in boxes), min(box.y0 for box in boxes)) >= -1.0
        assert max(box.x1 for box in boxes) <= width + 1.0
        assert max(box.y1 for box in boxes) <= height + 1.0


def test_panels_keep_the_given_order(run):
    figure = run.plot("position_error", "tension", "attitude", width="ieee")
    assert [axes.get_ylabel() for axes in figure.axes] == ["position error (mm)", "cable tension (N)", "attitude (°)"]
    screen = run.plot("position_error", "tension")
    assert [axes.get_ylabel() for axes in screen.axes] == ["position error (mm)", "cable tension (N)"]


def test_cables_by_name_and_number_keep_their_colours(run):
    for width in ("ieee", None):
        axes = run.plot("tension", "length", cables=[8, "cable_3"], width=width).axes
        for panel, values in zip(axes, (run.tension, run.length), strict=True):
            lines = [line for line in panel.lines if line.get_color() in CABLES]
            assert [line.get_color() for line in lines] == [CABLES[7], CABLES[2]]
            assert lines[0].get_ydata().max() == values[:, 7].max()
    for second in (2, "2", "cable_2", np.int64(2), np.array([2])):
        assert numbers(run, second) == [1]


def test_a_number_that_is_a_name_is_the_name(run):
    names = tuple(str(8 - i) for i in range(8))
    assert numbers(replace(run, header=replace(run.header, cables=names)), ["8", 8]) == [0, 7]


def test_limits_are_those_of_the_cables_that_are_drawn(run):
    head = replace(run.header, tension_max=(650.0,) * 3 + (700.0,) * 5)
    other = replace(run, header=head)
    heights = [line.get_ydata()[0] for line in other.plot("tension", cables=[5]).axes[0].lines]
    assert [height for height in heights if height > 640] == [700.0]


@pytest.mark.parametrize(
    ("names", "cables", "told"),
    [
        (["tensions"], None, "unknown panel 'tensions'; did you mean 'tension'"),
        ([7], None, "unknown panel 7; allowed: acceleration, "),
        ([["tension"]], None, r"unknown panel \['tension'\]; allowed: acceleration, "),
        (["tension"], 1.0, "unknown cable 1.0; "),
        (["tension"], ["9"], "unknown cable '9'; "),
        (["external_force"], None, "unknown panel 'external_force'; .*allowed: acceleration, "),
        (["tension"], [9], "unknown cable 9; allowed: numbers from 1 to 8, and names: cable_1, "),
        (["tension"], [0], "unknown cable 0; "),
        (["tension"], [True], "unknown cable True; "),
        (["tension"], ["cabel_1"], "unknown cable 'cabel_1'; did you mean 'cable_1'"),
        (["tension"], [], "cables is empty"),
        (["position"], [1], "cables: not used by position"),
    ],
)
def test_wrong_names_are_reported_with_what_is_allowed(run, names, cables, told):
    with pytest.raises(CdprError, match=f"plot: {told}") as error:
        run.plot(*names, cables=cables, width="ieee")
    assert "\n" not in str(error.value)


def test_the_overview_can_be_printed(run):
    assert len(run.plot(width="ieee").axes) == len(run.plot().axes) == 4


@pytest.mark.slow
@sampled(3, "case", CASES)
def test_any_run_can_be_plotted(case, tmp_path):
    if case == "100000 rows":
        pytest.skip("takes long, and is drawn as the others are")
    assert saved(CASES[case]().plot("tension", "position_error", width="ieee"), tmp_path, "svg").startswith(b"<?xml")


@pytest.mark.slow
def test_the_command_line_draws_figures_of_a_run(tmp_path):
    from matplotlib import figure as plain

    cdpr.simulate("caroca", out=tmp_path / "run", overrides={"simulation.duration": 0.1})
    out = tmp_path / "tension.pdf"
    what = ("view", tmp_path / "run", "--figure", "tension,position_error", "--cables", "1,cable_3", "--out")
    done = cdpr_here(*what, out)
    assert done.stdout.strip() == str(out)
    assert b"CIDFontType2" in font_types(out.read_bytes())
    first = out.read_bytes()
    assert cdpr_here(*what, out, "--force").returncode == 0  # over a figure of its kind
    assert out.read_bytes() == first
    (tmp_path / "mine.pdf").write_text("%PDF-1.7 precious")
    assert "is not a figure in PDF" in cdpr_here(*what, tmp_path / "mine.pdf", code=8).stderr
    assert (tmp_path / "mine.pdf").read_text() == "%PDF-1.7 precious"
    for suffix in ("pdf", "svg", "png"):
        theirs = tmp_path / f"theirs.{suffix}"
        plain.Figure().savefig(theirs)
        before = theirs.read_bytes()
        assert f"is not a figure in {suffix.upper()} that cdpr drew" in cdpr_here(*what, theirs, code=8).stderr
        assert theirs.read_bytes() == before
        assert cdpr_here(*what, tmp_path / f"ours.{suffix}").returncode == 0
        assert cdpr_here(*what, tmp_path / f"ours.{suffix}", "--force").returncode == 0
    assert cdpr_here(*what, tmp_path / "TENSION.PDF", "--width", "5").returncode == 0
    for empty in (("--figure", ","), ("--width", "")):
        cdpr_here(*what, tmp_path / "none.pdf", *empty, code=2)
    assert not (tmp_path / "none.pdf").exists()
    assert "--out NAME with .pdf, .svg, .png" in cdpr_here(*what, tmp_path / "figure.jpg", code=2).stderr
    assert (
        "--width and --cables are of a figure" in cdpr_here("view", tmp_path / "run", "--width", "ieee", code=2).stderr
    )
