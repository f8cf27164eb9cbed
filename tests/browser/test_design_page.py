"""The page of a design in a browser: both robots are drawn, and nothing of it is wider than the screen."""

from __future__ import annotations

import pytest
from browser_pages import PHONE
from design_cases import BOX, ONE, TWO, design_of

from cdpr.analysis.design import run_design
from cdpr.ui.report.pages.design import write_design

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module", params=[ONE, TWO], ids=["one", "several"])
def address(tmp_path_factory, request):
    folder = tmp_path_factory.mktemp("design")
    write_design(run_design(design_of(folder, BOX + request.param), folder / "out"), folder / "report.html")
    return (folder / "report.html").as_uri()


@pytest.mark.parametrize("look", [{}, {"color_scheme": "dark"}, PHONE], ids=["light", "dark", "phone"])
def test_both_robots_and_the_search_are_seen(open_page, address, look):
    page = open_page(address, **look)
    assert page.evaluate("cdpr.data.scenes.length") == 1
    for key in ("space", "before", "figures", "variables", "about"):
        assert page.locator(f"#{key}").is_visible()
    assert page.locator("#before svg").first.is_visible()
    assert page.locator("#search svg, #pareto-1 svg").first.is_visible()
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
