"""The page of a study in a browser: some cases play over one another, on any ground, width and paper."""

from __future__ import annotations

import numpy as np
import pytest
from browser_pages import PHONE, READY, pixels
from study_cases import write_study

from cdpr.analysis.study import load_study, run_study
from cdpr.ui.report.figures.study import multiples
from cdpr.ui.report.figures.study_layout import layouts
from cdpr.ui.report.pages.study import write_study as write_page
from cdpr.ui.report.style import CABLES
from cdpr.ui.report.text.study import FIGURES

pytestmark = pytest.mark.browser

SAME = 25  # in red, green and blue, from 0 to 255
SEEN = 40  # pixels at 100 to an inch

AXES = """keep: all
axes:
  - {key: solver.type, values: [qp, lp]}
  - {key: controller.kp, values: [50, 100, 200]}
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    return run_study(load_study(write_study(folder, AXES)), folder / "out")


@pytest.fixture(scope="module")
def study_page(results):
    path = results.folder / "study.html"
    write_page(results, path)
    return path


@pytest.fixture
def page(open_page, study_page, request):
    return open_page(study_page.as_uri(), **getattr(request, "param", {}))


def test_the_cases_play_over_one_another(page):
    assert page.evaluate("cdpr.data.scenes.length") == 4
    page.evaluate("cdpr.seek(0.05)")
    page.wait_for_function(READY, polling=50)
    places = page.evaluate("cdpr.viewer.pictures.map(({pose}) => Array.from(pose).slice(12, 15))")
    assert len(places) == 4
    assert all(place == pytest.approx(places[0], abs=1e-3) for place in places)
    page.evaluate("cdpr.speed = 0.1")
    page.keyboard.press("Space")
    page.wait_for_function("() => cdpr.time !== 0.05 && cdpr.playing")
    page.keyboard.press("Space")
    assert page.locator("#now").inner_text() == f"{page.evaluate('cdpr.time'):.3f} s"


def test_a_click_in_a_plot_of_the_cases_seeks(page):
    area = page.locator(".plot", has_text="position error (mm)").first.locator(".area")
    area.scroll_into_view_if_needed()
    drawn = "(area) => cdpr.plots.find((plot) => plot.area === area).size"  # what is not seen is not drawn
    page.wait_for_function(drawn, arg=area.element_handle())
    area.click()  # in its middle
    page.wait_for_function("() => 0.03 < cdpr.time && cdpr.time < 0.07")


def test_figures_fill_their_cards(page):
    for key in ("block1figure1_1", "block1figure1_4"):
        card = page.locator(f"#{key}").bounding_box()
        drawing = page.locator(f"#{key} svg[role=img]").bounding_box()
        assert drawing["width"] > 0.9 * card["width"]


@pytest.mark.parametrize("page", [PHONE, {"color_scheme": "dark"}], indirect=True)
def test_it_fits_a_phone_and_the_dark(page):
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator(".play").is_visible()


def test_printed_pages_have_static_figures_and_tables(page):
    page.emulate_media(media="print")
    assert not page.locator(".transport").is_visible()
    assert page.locator("#cases svg[role=img]").is_visible()
    assert page.locator("#block1figure1_1 svg[role=img]").is_visible()
    assert page.locator("#table table").is_visible()


def rgb(colour):
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])


@pytest.mark.parametrize("count", [2, 3, len(CABLES)])
def test_curves_upon_one_another_are_all_seen(count, open_page, tmp_path):
    """As lp and qp are, whose platforms go the same way: of each so much is drawn that the eye finds it."""
    values = ", ".join(str(10 * i) for i in range(1, count + 1))
    places = "{start: 100, stop: 900, count: 9}"
    axes = f"axes:\n  - {{key: controller.kd, values: [{values}]}}\n  - {{key: controller.kp, linspace: {places}}}\n"
    study = load_study(write_study(tmp_path, axes))
    error = FIGURES[0]
    records = [
        {**case.labels, "status": "finished", error.column: 1e-5 * case.labels["controller.kp"]} for case in study.cases
    ]
    figure = multiples(layouts(study.blocks[0])[0], records, error)
    (tmp_path / "figure.html").write_text(figure.markup("label", both=False))
    shown = open_page((tmp_path / "figure.html").as_uri(), ready="() => true", device_scale_factor=100 / 72)
    box = shown.locator("svg svg").first.bounding_box()  # not the legend
    image = pixels(shown, box)
    for colour in CABLES[:count]:
        seen = np.count_nonzero(np.abs(image - rgb(colour)).max(axis=1) < SAME)
        assert seen > SEEN, colour
