"""Figures on paper have letters that can be read, however many panels they have."""

from __future__ import annotations

import pytest
from chromium import browser, executable

import cdpr
from cdpr.analysis.compare.finished import compare_finished
from cdpr.ui.report.pages.compare import render

pytestmark = pytest.mark.browser
pytest.importorskip("playwright", reason="playwright is not installed: pip install 'cdpr[test]'")
if executable() is None:
    pytest.skip("there is no Chromium on this machine", allow_module_level=True)

PAPER = {"width": 718, "height": 1000}  # px, A4 without its margins
LETTERS, READ = 8.5, 5.0  # pt, as they are drawn, and as they must be at least: footnotes of journals have 6 to 7
SIZES = """() => [...document.querySelectorAll("figure .static svg")]
    .map((svg) => 0.75 * Math.min(svg.clientWidth / svg.viewBox.baseVal.width,
                                  svg.clientHeight / svg.viewBox.baseVal.height))"""


def test_differences_of_six_quantities_can_be_read(tmp_path):
    for name, gain in (("one", 100.0), ("other", 50.0)):
        cdpr.simulate("caroca", out=tmp_path / name, overrides={"simulation.duration": 0.1, "controller.kp": gain})
    path = tmp_path / "page.html"
    path.write_text(render(compare_finished([str(tmp_path / "one"), str(tmp_path / "other")])))
    with browser() as found:
        page = found.new_page(viewport=PAPER)
        page.emulate_media(media="print")
        page.goto(path.as_uri())
        scales = page.evaluate(SIZES)
    assert len(scales) >= 3
    assert min(scales) * LETTERS >= READ
