"""Windows in browsers stay with the run: two of them, one loaded again, one that lost its connection."""

from __future__ import annotations

import pytest
from study_cases import wait_until
from window_page import IS, PHASE, at, write

pytestmark = pytest.mark.browser

SHARED = 5  # rows that both have drawn

# Keep what is drawn of each frame, as "n: what".
REMEMBER = """() => {
  cdpr.seen = {};
  const draw = cdpr.draw.bind(cdpr);
  cdpr.draw = () => { draw(); if (cdpr.drawn.n >= 0) cdpr.seen[cdpr.drawn.n] = cdpr.drawn; };
}"""


def test_two_windows_show_the_same(visit):
    one, other = visit(), visit(color_scheme="dark")
    write(one, "robot.platform.mass", 19)
    other.wait_for_function(IS, arg=["robot.platform.mass", 19])
    assert at(other, "robot.platform.mass").input_value() == "19"
    for page in (one, other):
        page.evaluate(REMEMBER)
    one.get_by_role("button", name="Run", exact=True).click()
    both: set[str] = set()
    while len(both) < SHARED:  # each draws as often as it can
        one.wait_for_timeout(100)
        both = set(one.evaluate("Object.keys(cdpr.seen)")) & set(other.evaluate("Object.keys(cdpr.seen)"))
    other.get_by_role("button", name="Pause").click()
    for page in (one, other):
        page.wait_for_function(PHASE, arg="paused")
    drawn = "[cdpr.drawn, cdpr.frame.tension, cdpr.curves.panels[0].series[0].n]"
    seen, also = (page.evaluate("cdpr.seen") for page in (one, other))
    assert [seen[n] for n in sorted(both)] == [also[n] for n in sorted(both)]
    wait_until(lambda: one.evaluate(drawn) == other.evaluate(drawn))  # the last frame is sent anew


def test_a_reloaded_page_continues_at_the_state_of_the_run(page):
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.3")
    page.reload()
    page.wait_for_function("() => window.cdpr?.frame?.t > 0.5 && cdpr.curves.panels[0].series[0].time[0] < 0.1")


def test_a_connection_that_is_lost_is_reported_and_made_again(page):
    page.evaluate(
        """() => {
          const open = cdpr.link.open.bind(cdpr.link);
          cdpr.link.open = () => setTimeout(open, 300);
          cdpr.link.socket.close();
        }"""
    )
    page.locator("#lost").wait_for(state="visible")
    page.keyboard.press("Space")
    page.locator(".messages li", has_text="Not connected").wait_for(state="attached")
    page.locator("#lost").wait_for(state="hidden")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function(PHASE, arg="running")
