"""What notebooks show, in a browser: several frames on one page, each with a player of its own."""

from __future__ import annotations

import pytest
from chromium import browser, executable

import cdpr

pytestmark = pytest.mark.browser
pytest.importorskip("playwright", reason="playwright is not installed: pip install 'cdpr[test]'")
if executable() is None:
    pytest.skip("there is no Chromium on this machine", allow_module_level=True)

READY = "() => window.cdpr !== undefined && !window.cdpr.waiting"


@pytest.mark.parametrize("width", [1000, 390])
def test_several_on_one_page_do_not_collide(tmp_path, width):
    scenario = cdpr.load_scenario("cable_break", overrides={"simulation.duration": 0.2})
    simulation = cdpr.Simulation(scenario)
    simulation.step(50)
    run = cdpr.simulate(scenario)
    cells = [thing._repr_html_() for thing in (scenario.robot, scenario, run, run, simulation)]
    simulation.close()
    path = tmp_path / "cells.html"
    path.write_text(f'<!DOCTYPE html><meta charset="utf-8"><body>{"<hr>".join(cells)}</body>')
    told = []
    with browser() as chromium:
        page = chromium.new_page(viewport={"width": width, "height": 4000})
        page.on("console", lambda message: told.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: told.append(str(error)))
        page.goto(path.as_uri())
        page.wait_for_function("() => frames.length === 5")
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
    assert told == []
