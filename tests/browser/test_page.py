"""Pages in a browser: they play, seek, zoom, print and fit a phone, and request no other resource."""

from __future__ import annotations

import re
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest
from browser_pages import PHONE, READY, pixels
from command_line import cdpr_here
from conftest import ROOT
from report_cases import CASES, LED
from sagging_curves import integrated

import cdpr
from cdpr.ui.report.pages.run import write_report

pytestmark = pytest.mark.browser

MOST_LINES = 600  # of a frame; what is drawn in software takes its time from them (benchmarks/page.py measures it)

# How many lines the painter is given for the next frame.
LINES = """(t) => new Promise((done) => {
  const painter = cdpr.viewer.painter;
  painter.draw = function (camera, ratio, lines, solids) {
    delete painter.draw;
    done(lines.reduce((sum, part) => sum + part.count, 0));
    return painter.draw(camera, ratio, lines, solids);
  };
  cdpr.seek(t);
})"""


# The numbers at the axis of values of a small plot, if it shows this range.
NUMBERS = """(range) => {
  const plot = cdpr.plots.find((found) => found.panel.label.startsWith("angular velocity"));
  const c = plot.base.getContext("2d"), told = [];
  c.fillText = function (text) { if (this.textAlign === "right") told.push(text); };
  plot.panel.range = range;
  plot.draw();
  delete c.fillText;
  return told;
}"""


@pytest.fixture(scope="module")
def run():
    return cdpr.simulate("cable_break", overrides={"simulation.duration": 2.0})


@pytest.fixture(scope="module")
def report(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_report(run, path)
    return path


@pytest.fixture
def page(open_page, report, request):
    options = dict(getattr(request, "param", {}))
    return open_page(report.as_uri() + options.pop("part", ""), **options)


def seek(page, t):
    page.evaluate("(t) => cdpr.seek(t)", t)
    page.wait_for_function(READY, polling=50)


def area(page, label):
    return page.locator(".plot", has_text=label).first.locator(".area")


def test_the_space_bar_plays_and_stops_and_arrows_step(page):
    page.keyboard.press("Space")
    page.wait_for_function("() => cdpr.time > 0.2")
    page.keyboard.press("Space")
    there = page.evaluate("cdpr.time")
    assert page.locator("#now").inner_text() == f"{there:.3f} s"
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    assert 0.0 < page.evaluate("cdpr.time") < 0.05
    page.keyboard.press("Shift+ArrowRight")
    assert 0.1 < page.evaluate("cdpr.time") < 0.3


def test_a_way_costs_what_is_seen_of_it(page):
    """The path of the platform is drawn up to the current time, without points that no screen resolves."""
    away, lines, points, drawn = page.evaluate("""() => {
        const { done } = cdpr.viewer.ways[0], film = cdpr.viewer.films[0], last = film.time.length - 1;
        const end = done.data.subarray(12 * done.count - 9, 12 * done.count - 6);
        const there = film.position.subarray(3 * last);
        const away = Math.hypot(...[0, 1, 2].map((i) => there[i] - end[i])) / cdpr.viewer.camera.radius;
        return [away, done.count, last, done.upto[last]];
    }""")
    assert 10 < lines < points
    assert drawn == lines
    assert away < 2e-3


def test_a_tool_is_shown_and_its_way(open_page, tmp_path):
    run = cdpr.simulate("caroca", overrides=LED)
    write_report(run, tmp_path / "report.html")
    page = open_page((tmp_path / "report.html").as_uri())
    ways = page.evaluate("""() => {
        const { desired, done } = cdpr.viewer.ways[0];
        return [desired, done].map(({ data, count }) => Array.from(data.subarray(12 * count - 9, 12 * count - 6)));
    }""")
    np.testing.assert_allclose(ways, [LED["trajectory"]["to"]["position"]] * 2, atol=5e-3)
    labels = page.evaluate("cdpr.viewer.written")  # what is written into the scene
    assert "nozzle" in labels
    assert "eye" in labels


def test_axes_begin_at_the_origin_of_the_world(page):
    """They are the last three lines of the static content."""
    ends = page.evaluate("""() => {
        const { data, count } = cdpr.viewer.fixed[0];
        return [3, 2, 1].map((k) => Array.from(data.subarray(12 * (count - k), 12 * (count - k) + 6)));
    }""")
    length = page.evaluate("cdpr.viewer.axes.length")
    np.testing.assert_allclose(ends, np.hstack([np.zeros((3, 3)), length * np.eye(3)]), atol=1e-6)
    assert length > 0.1


def test_nothing_lies_upon_the_legend(page):
    """When the page opens, the transport bar at the window's edge must not hide content."""
    legend, transport = (page.locator(f"#viewer .{name}").bounding_box() for name in ("legend", "transport"))
    assert legend["y"] + legend["height"] <= min(transport["y"], 800.0)


def test_a_click_in_a_plot_seeks_and_the_scene_follows(page, run):
    box = area(page, "cable tension (N)").bounding_box()
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_function(READY, polling=50)
    t = page.evaluate("cdpr.time")
    assert 0.8 < t < 1.2
    drawn = page.evaluate("Array.from(cdpr.viewer.pictures[0].pose)")
    row = round(t / run.header.control_step)
    assert drawn[12:15] == pytest.approx(run.position[row], abs=2e-3)
    assert float(page.locator("#slider").input_value()) == pytest.approx(t)


def test_platform_and_cables_are_of_one_row(page, run):
    for t in (0.3, 1.5):
        seek(page, t)
        picture = page.evaluate("(({pose, tips}) => ({pose: Array.from(pose), tips}))(cdpr.viewer.pictures[0])")
        pose = np.array(picture["pose"]).reshape(4, 4).T
        B = np.array(run.header.anchors)[:, 3:]
        assert np.array(picture["tips"]) == pytest.approx(B @ pose[:3, :3].T + pose[:3, 3], abs=1e-5)
        # Rows are drawn at no more than 60 Hz, and from one to the next the platform goes straight on.
        assert pose[:3, 3] == pytest.approx(run.position[round(t / run.header.control_step)], abs=1e-3)


def test_a_cable_is_broken_from_its_event_on(page):
    seek(page, 0.9985)
    assert page.evaluate("Array.from(cdpr.viewer.pictures[0].state)")[1] != 4
    seek(page, 1.0005)
    assert page.evaluate("Array.from(cdpr.viewer.pictures[0].state)")[1] == 4


def test_hovering_reports_values(page, run):
    plot = page.locator(".plot", has_text="cable tension (N)").first
    box = plot.locator(".area").bounding_box()
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 20)
    page.wait_for_function("() => cdpr.hover !== null && !cdpr.waiting")
    row = round(page.evaluate("cdpr.hover") / run.header.control_step)
    told = [float(text) for text in plot.locator(".series b").all_inner_texts()]
    assert told == pytest.approx(run.tension[row], rel=0.02)


def test_round_off_is_shown_as_zero(page):
    """At the start there is no error: neither steps of the stored numbers nor round-off are shown."""
    for label in ("position error (mm)", "acceleration (m/s²)"):
        area(page, label).scroll_into_view_if_needed()
        seek(page, 0.0)
        values = page.locator(".plot", has_text=label).first.locator(".series b")
        page.wait_for_function("(node) => node.textContent", arg=values.last.element_handle(), polling=50)
        assert set(values.all_inner_texts()) == {"0"}, label


@pytest.mark.parametrize("ends", [(-0.85e-3, 0.9e-3), (-3.0, 3.9), (0.31, 0.49), (1.0, 2.1)])
def test_every_axis_has_two_numbers(page, ends):
    numbers = page.evaluate(NUMBERS, ends)
    assert len(set(numbers)) >= 2, numbers


def test_dragging_zooms_all_plots_and_a_double_click_shows_all(page):
    plot = area(page, "cable tension (N)")
    box = plot.bounding_box()
    middle = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + 0.4 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], middle, steps=4)
    page.mouse.up()
    low, high = page.evaluate("cdpr.window")
    assert 0.6 < low < 0.9
    assert 1.1 < high < 1.4
    page.get_by_text("Whole time").wait_for()  # the next drawing shows it
    plot.dblclick()
    assert page.evaluate("cdpr.window") == [0, 2]


def test_a_series_is_switched_off_in_all_plots_of_cables(page):
    before = page.evaluate("cdpr.hidden.size")
    page.locator(".plot", has_text="cable tension (N)").first.get_by_role("button", name=re.compile("cable_3")).click()
    pressed = page.locator('.series button[aria-pressed="false"]')
    assert before == 0
    assert pressed.count() == 3  # tension, length and rate
    assert all("cable_3" in text for text in pressed.all_inner_texts())


def test_an_event_leads_to_its_time(page):
    page.locator("button[data-time]").first.click()
    assert page.evaluate("cdpr.time") == 1.0


@pytest.mark.parametrize("page", [{"part": "#gl"}, {"part": "#flat"}], indirect=True)
def test_the_scene_is_drawn_of_few_lines_with_and_without_webgl(page, request):
    flat = "#flat" in page.url
    assert page.evaluate("cdpr.viewer.painter.constructor.name") == ("FlatPainter" if flat else "GlPainter")
    assert 50 < page.evaluate(LINES, 1.0) < MOST_LINES
    box = page.locator(".screen").bounding_box()
    colours = np.unique(pixels(page, box), axis=0)
    assert len(colours) > 20
    written = "Array.from(cdpr.viewer.paper.getContext('2d').getImageData(0, 0, 500, 500).data).some((x) => x > 0)"
    assert page.evaluate(written)  # numbers of cables, names of axes


@pytest.mark.parametrize("page", [{"color_scheme": "dark"}], indirect=True)
def test_in_the_dark_the_ground_is_dark(page):
    assert page.evaluate("cdpr.dark")
    ground = page.evaluate("getComputedStyle(document.querySelector('figure')).backgroundColor")
    assert ground == "rgb(21, 24, 29)"


@pytest.mark.parametrize("page", [PHONE], indirect=True)
def test_a_phone_shows_it_without_scrolling_sideways_and_a_finger_seeks(page):
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    plot = area(page, "cable tension (N)")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.touchscreen.tap(box["x"] + 0.6 * box["width"], box["y"] + 0.6 * box["height"])
    assert 0.9 < page.evaluate("cdpr.time") < 1.5
    assert page.locator(".play").is_visible()  # the transport stays in view


@pytest.mark.parametrize("page", [{"reduced_motion": "reduce"}], indirect=True)
def test_reduced_motion_disables_looping(page):
    assert page.evaluate("[cdpr.loop, cdpr.playing]") == [False, False]


def test_on_paper_it_has_two_pages_without_yaml(page):
    text = page.pdf(format="A4", prefer_css_page_size=True)
    assert len(re.findall(rb"/Type\s*/Page\b", text)) == 2
    page.emulate_media(media="print")
    shown = SimpleNamespace(**{key: page.locator(f"#{key}").is_visible() for key in ("tensions", "scenario", "pose")})
    assert shown == SimpleNamespace(tensions=True, scenario=False, pose=False)
    assert page.locator("#tensions svg[role=img]").is_visible()
    assert not page.locator(".transport").is_visible()


def test_a_robot_is_on_paper_and_there_without_script(chromium, open_page, tmp_path):
    path = tmp_path / "view.html"
    cdpr_here("view", ROOT / "scenarios" / "robots" / "cogiro.yaml", "--no-open", "--out", path)
    still = "#robot svg[role=img]"
    page = open_page(path.as_uri())
    assert not page.locator(still).is_visible()  # the scene plays in its place
    page.emulate_media(media="print")
    assert page.locator(still).is_visible()
    assert not page.locator("#viewer").is_visible()
    with closing(chromium.new_context(java_script_enabled=False)) as without:
        page = without.new_page()
        page.goto(path.as_uri())
        assert page.locator(still).is_visible()


ODD = ("infeasible", "diverged", "one row", "two rows", "one cable", "12 cables", "long names", "far limits")


@pytest.mark.parametrize("case", ODD)
def test_odd_runs_play_without_an_error(open_page, tmp_path, case):
    path = tmp_path / "report.html"
    write_report(CASES[case](), path)
    page = open_page(path.as_uri())
    low, high = page.evaluate("cdpr.data.span")
    for part in (0.25, 0.9, 1.0):
        seek(page, low + part * (high - low))
    page.evaluate("cdpr.zoom(cdpr.time, cdpr.time)")
    page.wait_for_function(READY, polling=50)
    assert page.evaluate("document.documentElement.scrollWidth") <= 1200


# Ends of all lines that the painter is given for the next frame, and their colours.
ENDS = """(t) => new Promise((done) => {
  const painter = cdpr.viewer.painter;
  painter.draw = function (camera, ratio, lines, solids) {
    delete painter.draw;
    done(lines.flatMap((part) => Array.from(part.data).slice(0, 12 * part.count)));
    return painter.draw(camera, ratio, lines, solids);
  };
  cdpr.seek(t);
})"""


def test_cables_that_sag_are_drawn_as_curves(open_page, tmp_path):
    heavy = {"simulation.duration": 0.1, "robot.cable.linear_density": 0.6}
    run = cdpr.simulate("sagging", overrides=heavy)
    write_report(run, tmp_path / "report.html")
    page = open_page((tmp_path / "report.html").as_uri())
    lines = np.reshape(page.evaluate(ENDS, 0.05), (-1, 12))
    robot = cdpr.load_scenario("sagging", overrides=heavy).robot
    pose = np.concatenate([run.position[50], run.orientation[50]])
    share = np.linspace(0.0, 1.0, 51)[:, None]
    drawn = np.concatenate([a + share * (b - a) for a, b in zip(lines[:, :3], lines[:, 3:6], strict=True)])
    for (_, curve), anchor in zip(integrated(robot, pose, run["unstretched_length"][50]), robot.anchors, strict=True):
        middle = curve[len(curve) // 2]
        assert np.linalg.norm(middle - 0.5 * (curve[0] + anchor[:3])) > 0.03  # off the chord
        assert np.linalg.norm(drawn - middle, axis=1).min() < 0.03
