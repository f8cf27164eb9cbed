"""Images of cameras in the player of a report, which follow its time, and in the window."""

from __future__ import annotations

from base64 import b64encode

import pytest
from browser_pages import READY
from conftest import ROOT
from window_page import DRAWN, PHASE

import cdpr
from cdpr.log.images import images, png
from cdpr.sensing import rendering
from cdpr.ui.report.pages.run import write_report

pytestmark = pytest.mark.browser

SCENARIO = ROOT / "scenarios" / "camera.yaml"
SHORT = {"simulation.duration": 0.4}
SHOWN = """() => [...document.querySelectorAll("[data-camera]")].map((box) => {
  const image = box.querySelector("img");
  return [box.dataset.camera, box.querySelector("output").textContent, image.src, image.naturalWidth];
})"""
LOADED = "() => [...document.querySelectorAll('.cameras img')].every((image) => image.complete)"


@pytest.fixture(scope="module", autouse=True)
def usable():
    try:
        rendering.make_renderer("auto", rendering.Lens((100.0, 100.0), (8.0, 8.0), (16, 16))).close()
    except cdpr.CdprError as error:
        pytest.skip(str(error))


def address(image):
    return f"data:image/png;base64,{b64encode(png(image)).decode()}"


def test_images_of_a_report_follow_the_time_of_the_player(open_page, tmp_path):
    run = cdpr.simulate(SCENARIO, overrides=SHORT)
    write_report(run, tmp_path / "report.html")
    page = open_page((tmp_path / "report.html").as_uri())
    expected = {name: [address(image) for _, image in images(run, name)] for name in ("roof", "tool")}
    for time, k in ((0.0, 0), (0.1, 1), (0.29, 2), (0.3, 3), (0.4, 4), (0.05, 0)):
        page.evaluate("(t) => cdpr.seek(t)", time)
        page.wait_for_function(READY, polling=50)
        page.wait_for_function(LOADED, polling=50)
        shown = [(name, f"{0.1 * k:.3f} s", expected[name][k], width) for name, width in (("roof", 640), ("tool", 320))]
        assert page.evaluate(SHOWN) == [list(each) for each in shown]
    with_all = page.evaluate("cdpr.images.cameras.map(({ images }) => images.length)")
    assert with_all == [5, 5]


@pytest.fixture
def window():
    pytest.importorskip("websockets", reason="websockets is not installed: pip install 'cdpr[gui]'")
    from cdpr.ui.gui.editor import Editor
    from cdpr.ui.gui.window import Window

    with Window(Editor(str(SCENARIO)), lambda text: None, port=0) as found:
        found.begin()
        yield found


def test_the_window_shows_the_latest_images(window, open_page):
    page = open_page(window.address, DRAWN, viewport={"width": 1500, "height": 900})
    page.get_by_role("tab", name="Images").click()
    assert "roof: no image before the first step" in page.locator(".cameras").inner_text()
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function(PHASE, arg="done", timeout=60_000)
    page.wait_for_function("() => document.querySelector('.cameras').textContent.includes('roof, 4.000 s')")
    found = page.locator(".cameras img").evaluate_all("all => all.map((image) => image.src)")
    run = cdpr.simulate(SCENARIO)
    assert found == [address([image for _, image in images(run, name)][-1]) for name in ("roof", "tool")]
