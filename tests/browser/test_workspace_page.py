"""Page of a workspace in a browser: its surface surrounds the robot, and rotates with it."""

from __future__ import annotations

import numpy as np
import pytest
from browser_pages import PHONE, pixels
from conftest import ROOT

from cdpr import load_robot
from cdpr.analysis.workspace import region, workspace
from cdpr.ui.report.pages.workspace import render_workspace

pytestmark = pytest.mark.browser

SEEN = 5000  # pixels of some 400 000 of the scene that the surface covers, at least


@pytest.fixture(scope="module")
def robot():
    return load_robot(ROOT / "scenarios" / "robots" / "cogiro.yaml")


@pytest.fixture(scope="module")
def found(robot):
    return workspace(robot, "static", region(robot, cells=16))


@pytest.fixture
def page(open_page, found, robot, tmp_path, request):
    path = tmp_path / "w.html"
    path.write_text(render_workspace(found, robot))
    return open_page(path.as_uri(), **getattr(request, "param", {}))


def seen(page):
    """The scene's pixels, (n, 3)."""
    box = page.locator("canvas").first.bounding_box()
    return pixels(page, box)


@pytest.mark.parametrize("page", [{"color_scheme": "dark"}], indirect=True)
def test_the_surface_is_drawn_and_turns(page):
    before = seen(page)
    page.evaluate(
        "() => { cdpr.viewer.films[0].hidden = cdpr.viewer.films[0].room; cdpr.viewer.films[0].room = null; }"
    )
    page.evaluate("() => cdpr.viewer.draw()")
    without = seen(page)
    assert (np.abs(before - without).max(axis=1) > 10).sum() > SEEN
    page.evaluate("() => { cdpr.viewer.films[0].room = cdpr.viewer.films[0].hidden; cdpr.viewer.draw(); }")
    page.get_by_role("button", name="Top").click()
    page.wait_for_timeout(500)
    assert (np.abs(seen(page) - before).max(axis=1) > 10).sum() > SEEN


@pytest.mark.parametrize("page", [PHONE], indirect=True)
def test_on_a_phone_nothing_is_wider_than_the_page(page):
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    assert page.locator("figure svg").count() >= 3


def test_the_workspace_is_on_paper(page, found, robot, tmp_path):
    """Its faces are drawn in the picture that takes the place of the scene."""
    page.emulate_media(media="print")
    assert not page.locator("#viewer").is_visible()
    picture = page.locator("figure svg[role=img]").first
    assert picture.is_visible()
    faces = picture.evaluate("(svg) => [...svg.querySelectorAll('path')].map((path) => path.getAttribute('d').length)")
    assert sum(faces) > 20_000  # characters; the robot alone takes about 1000
