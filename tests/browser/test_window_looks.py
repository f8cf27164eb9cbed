"""Display of the window in a browser: one row at a time, whole numbers, names, on any background and width."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from browser_pages import PHONE
from gui_cases import SCENARIO
from window_page import PHASE, run_to_the_end, write

import cdpr

pytestmark = pytest.mark.browser

SCREEN = 1e-5  # m: frames hold lengths to a micrometre, and pages draw them as float32


@pytest.mark.parametrize(
    "example", ["", "cogiro_pulleys"]
)  # whose cables leave from where they now leave their pulleys
def test_cables_and_platform_are_always_drawn_from_one_row(page, files, example):
    if example:
        page.evaluate("(name) => { cdpr.viewer.films[0].before = true; cdpr.send({do: 'open', name}); }", example)
        page.wait_for_function("() => !cdpr.viewer.films[0].before && cdpr.phase === 'ready'")
    page.evaluate("""() => {
      cdpr.seen = [];
      const draw = cdpr.draw.bind(cdpr);
      cdpr.draw = () => { draw(); cdpr.seen.push(cdpr.drawn); };
    }""")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.drawn.t > 0.9")
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function(PHASE, arg="paused")
    seen = [drawn for drawn in page.evaluate("cdpr.seen") if drawn["n"] is not None and drawn["n"] >= 0]
    assert len({drawn["n"] for drawn in seen}) > 3
    run = cdpr.simulate(example or files.scenario, overrides={"simulation.duration": seen[-1]["t"] + 0.001})
    rows = [drawn["n"] for drawn in seen]
    ends = run.header.subject.ends(run.position[rows], run.orientation[rows])
    for drawn, n, (exits, tips) in zip(seen, rows, np.moveaxis(ends, 2, 1), strict=True):
        assert np.array(drawn["pose"][12:15]) == pytest.approx(run.position[n], abs=SCREEN)
        assert np.array(drawn["exits"]).reshape(-1, 3) == pytest.approx(exits, abs=SCREEN)
        assert np.array(drawn["tips"]) == pytest.approx(tips, abs=SCREEN)
        assert drawn["t"] == pytest.approx(run.time[n], abs=1e-6)


# How much ink, 0 to 255, of names lies on each tool's place, and of the scene; and how much of names there is in all.
INK = """() => {
  const { viewer } = cdpr, { camera, paper, ratio } = viewer, [film] = viewer.films, ink = paper.getContext("2d");
  const view = camera.matrix(), { pose } = viewer.pictures[0];
  const there = ([x, y, z]) => [0, 1, 2].map((i) => pose[i] * x + pose[4 + i] * y + pose[8 + i] * z + pose[12 + i]);
  const places = Object.values(film.tools).map((tool) => camera.project(view, there(tool)));
  const { width, height } = paper, all = ink.getImageData(0, 0, width, height).data.filter((x, i) => i % 4 === 3);
  const scene = document.createElement("canvas").getContext("2d");
  Object.assign(scene.canvas, { width, height });
  viewer.draw();
  scene.drawImage(viewer.canvas, 0, 0);
  const drawn = scene.getImageData(0, 0, width, height).data.filter((x, i) => i % 4 === 3);
  const on = (ink) => places.map(([x, y]) => ink[width * Math.round(y * ratio) + Math.round(x * ratio)]);
  return [on(all), on(drawn), all.filter((x) => x).length];
}"""


def test_names_of_tools_leave_their_places_to_be_seen(page):
    points = {"a_long_name_on_the_right": [1.2, 0.0, 0.1], "a_long_name_on_the_left": [-1.2, 0.0, 0.1]}
    page.evaluate("(value) => cdpr.send({ do: 'edit', path: 'robot.platform.tools', value })", points)
    page.evaluate("cdpr.send({ do: 'apply' })")
    page.wait_for_function("() => cdpr.viewer.films[0].tools && cdpr.phase === 'ready'")
    page.get_by_role("button", name="Front").click()
    page.wait_for_timeout(500)  # ms: it turns there
    names, points, whole = page.evaluate(INK)
    assert names == [0, 0]
    assert points == [255, 255]
    assert whole > 1000


def test_hovering_a_plot_reports_values_and_a_series_can_be_switched_off(page):
    run_to_the_end(page)
    page.wait_for_function("() => cdpr.curves.latest > 5.9")
    plot = page.locator("#curves .plot").first
    box = plot.locator(".area").bounding_box()
    page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 20)
    page.wait_for_function("() => cdpr.hover !== null && !cdpr.waiting")
    t = page.evaluate("cdpr.hover")
    curves = page.evaluate(
        "cdpr.curves.panels[0].series.map((curve) => [Array.from(curve.time), Array.from(curve.value)])"
    )
    told = [float(text) for text in plot.locator(".series b").all_inner_texts()]
    assert told == pytest.approx([np.interp(t, time, value) for time, value in curves], rel=0.02)
    plot.get_by_role("button", name="cable_3").click()
    assert plot.locator('.series button[aria-pressed="false"]').count() == 1


def test_a_colour_that_is_not_given_is_shown_as_it_is_drawn(page):
    picked = page.get_by_label("robot, platform, colour, picked")
    assert picked.input_value() == page.evaluate("cdpr.data.colours.body[0]").lower()


def test_numbers_of_an_inertia_are_seen_whole(visit):
    page = visit(viewport={"width": 1200, "height": 800})
    write(page, "robot.platform.inertia", 0.866667, 0.866667, 1.234567, 0, 0, 0)
    cut = "(nodes) => nodes.filter((node) => node.scrollWidth > node.clientWidth + 1).length"  # px: both are rounded
    assert page.locator('[data-path="robot.platform.inertia"] input').evaluate_all(cut) == 0


def test_names_and_texts_of_files_are_texts(files, page):
    evil = "<img src=x onerror=alert(1)>"
    (files.folder / f"{evil}.yaml").write_text(SCENARIO.replace("quintic", evil))
    page.get_by_role("button", name="Open…").click()
    dialog = page.locator("dialog[open]")
    dialog.get_by_role("combobox").fill(str(files.folder / f"{evil}.yaml"))
    dialog.get_by_role("button", name="Open").click()
    page.wait_for_function("() => cdpr.form.message.problems.length > 0")
    assert evil in page.locator("#file").inner_text()
    assert evil in page.locator(".problems").inner_text()  # the message shows what was found
    assert page.locator("img").count() == 0


UNFOLD = """() => {
  const folded = document.querySelectorAll('.fold[aria-expanded="false"]:not([disabled])');
  folded.forEach((node) => node.click());
  return folded.length;
}"""
# Names of all controls outside dialogs, on any tab, for screen readers.
NAMES = """() => [...document.querySelectorAll("button:not([role=tab]), input, select, textarea, canvas[tabindex]")]
  .filter((node) => !node.hidden && !node.closest("dialog, #curves, .lines[hidden]"))
  .map((node) => node.getAttribute("aria-label") || [...(node.labels || [])].map((label) => label.textContent).join()
    || node.textContent)"""


def test_every_control_has_a_name_of_its_own(page):
    while page.evaluate(UNFOLD):
        pass
    names = page.evaluate(NAMES)
    assert len(names) > 100
    assert all(name.strip() for name in names)
    assert [name for name, count in Counter(names).items() if count > 1] == []


def test_a_phone_shows_it_without_scrolling_sideways(visit):
    page = visit(**PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.get_by_role("button", name="Run", exact=True).tap()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    assert page.get_by_role("button", name="Emergency stop").is_visible()
    assert not page.locator("#form").is_visible()
    page.get_by_role("button", name="Form", exact=True).tap()
    write(page, "robot.platform.mass", 18)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_in_the_dark_the_ground_is_dark(visit):
    page = visit(color_scheme="dark")
    assert page.evaluate("cdpr.dark")
    for part in ("#form", "#scene", "#side", "#top", "#bottom"):
        assert (
            page.evaluate("(part) => getComputedStyle(document.querySelector(part)).backgroundColor", part)
            == "rgb(21, 24, 29)"
        )
