"""Notebook displays in a browser: several frames on one page, each with its own player."""

from __future__ import annotations

import pytest
from browser_pages import READY

import cdpr

pytestmark = pytest.mark.browser


@pytest.mark.parametrize("width", [1000, 390])
def test_several_on_one_page_do_not_collide(open_page, tmp_path, width):
    scenario = cdpr.load_scenario("cable_break", overrides={"simulation.duration": 0.2})
    simulation = cdpr.Simulation(scenario)
    simulation.step(50)
    run = cdpr.simulate(scenario)
    cells = [thing._repr_html_() for thing in (scenario.robot, scenario, run, run, simulation)]
    simulation.close()
    path = tmp_path / "cells.html"
    path.write_text(f'<!DOCTYPE html><meta charset="utf-8"><body>{"<hr>".join(cells)}</body>')
    page = open_page(path.as_uri(), "() => frames.length === 5", viewport={"width": width, "height": 4000})
    frames = page.frames[1:]
    for frame in frames:
        frame.wait_for_function(READY, polling=50)
    _, motion, first, second, _ = frames
    first.evaluate("cdpr.seek(0.1)")
    assert [frame.evaluate("cdpr.time") for frame in (motion, first, second)] == [0.0, 0.1, 0.0]
    second.locator(".play").click()
    second.wait_for_function("() => cdpr.time > 0")
    assert first.evaluate("cdpr.playing") is False
    for frame in frames:
        assert frame.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert frame.evaluate("document.querySelector('.screen').getBoundingClientRect().height") > 100
    assert page.evaluate("[window.cdpr, document.documentElement.className]") == [None, ""]
