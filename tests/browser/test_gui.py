"""The window of `cdpr gui` in a browser: it edits, runs, disturbs, and asks for nothing but its own socket."""

from __future__ import annotations

import re
from collections import Counter
from contextlib import closing
from functools import reduce
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from chromium import browser, executable
from gui_cases import ROBOT, SCENARIO

import cdpr

pytestmark = pytest.mark.browser
pytest.importorskip("playwright", reason="playwright is not installed: pip install 'cdpr[test]'")
pytest.importorskip("websockets", reason="websockets is not installed: pip install 'cdpr[gui]'")
if executable() is None:
    pytest.skip("there is no Chromium on this machine", allow_module_level=True)

READY = "() => window.cdpr !== undefined && cdpr.drawn !== null && cdpr.form.message !== null && cdpr.phase === 'ready'"
PHASE = "(phase) => cdpr.phase === phase"
PATIENCE = 15_000  # ms, on a machine that does other things besides
SCREEN = 1e-5  # m: frames hold lengths to a micrometre, and pages draw them as float32
SAID = "(words) => document.querySelector('#status .text').textContent.includes(words)"

# The value of a field or of a table's cell in the form that the page has been told.
VALUE = """(path) => {
  const seek = (fields) => {
    for (const field of fields) {
      if (field.path === path) return field.value;
      for (const row of field.rows || []) {
        for (const [key, cell] of Object.entries(row.cells)) if (`${row.path}.${key}` === path) return cell.value;
      }
      const found = seek(field.fields || []);
      if (found !== undefined) return found;
    }
  };
  return seek(cdpr.form.message.tabs.flatMap((tab) => tab.fields));
}"""
IS = f"([path, value]) => JSON.stringify(({VALUE})(path)) === JSON.stringify(value)"


UNFOLD = """() => {
  const folded = document.querySelectorAll('.fold[aria-expanded="false"]:not([disabled])');
  folded.forEach((node) => node.click());
  return folded.length;
}"""
# Of all that can be operated without a dialog, on any tab: the name that screen readers say.
NAMES = """() => [...document.querySelectorAll("button:not([role=tab]), input, select, textarea, canvas[tabindex]")]
  .filter((node) => !node.hidden && !node.closest("dialog, #curves, .lines[hidden]"))
  .map((node) => node.getAttribute("aria-label") || [...(node.labels || [])].map((label) => label.textContent).join()
    || node.textContent)"""


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture
def files(tmp_path):
    found = SimpleNamespace(robot=tmp_path / "seven.yaml", scenario=tmp_path / "rise.yaml", folder=tmp_path)
    found.robot.write_text(ROBOT)
    found.scenario.write_text(SCENARIO)
    return found


@pytest.fixture
def window(files):
    from cdpr.gui.desk import Desk
    from cdpr.gui.window import Window

    told = []
    with Window(Desk(str(files.scenario)), told.append, port=0) as found:
        found.begin()
        yield found
    assert told == []  # nothing that the terminal should have


@pytest.fixture
def visit(chromium, window):
    """Opens windows; none of them may tell of an error, or ask for anything elsewhere."""
    contexts, told = [], []

    def open_one(**options):
        contexts.append(chromium.new_context(**{"viewport": {"width": 1500, "height": 900}, **options}))
        page = contexts[-1].new_page()
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda message: told.append(message.text) if message.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: told.append(str(error)))
        page.on("request", lambda asked: told.append(asked.url) if asked.url != window.address else None)
        page.goto(window.address)
        page.wait_for_function(READY)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert told == []


@pytest.fixture
def page(visit):
    return visit()


def at(page, path):
    """The inputs of a field, on its tab and unfolded."""
    page.evaluate(
        "(path) => cdpr.form.lead(path, path.startsWith('robot') ? 'robot' : path.startsWith('simulation') ? "
        "'simulation' : path.startsWith('trajectory') ? 'motion' : 'control')",
        path,
    )
    return page.locator(f'[data-path="{path}"]').first.locator("input, select, textarea")


def write(page, path, *values):
    """Write into the fields of a path as hands do, and wait until the program has it."""
    inputs = at(page, path)
    for i, value in enumerate(values):
        inputs.nth(i).fill(str(value))
        if inputs.nth(i).get_attribute("type") != "color":  # where Enter opens a palette
            inputs.nth(i).press("Enter")
    page.wait_for_function(IS, arg=[path, list(values) if len(values) > 1 else values[0]])


def choose(page, path, label):
    page.get_by_label(path, exact=True).select_option(label=label)


def apply(page):
    page.evaluate("cdpr.stage.films[0].before = true")
    page.get_by_role("button", name="Apply").click()
    page.wait_for_function("() => cdpr.form.message.applied && !cdpr.stage.films[0].before && cdpr.phase === 'ready'")


def run_to_the_end(page):
    page.get_by_role("button", name="As fast as it goes").click()
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => ['done', 'ended', 'failed'].includes(cdpr.phase)")


def test_each_edit_of_the_thesis_window_is_applied_saved_and_read_back(page, files):
    edits = {
        "robot.cables[1].frame": [-2.1, 2, 3.1],  # exit point
        "robot.cables[6].platform": [0.3, 0.3, -0.15],  # anchor on the platform
        "robot.platform.mass": 21.5,
        "robot.platform.colour": "#336699",
        "robot.platform.inertia": [0.9, 0.9, 1.25, 0, 0, 0],
        "robot.home.position": [0, 0.05, 1.45],
        "robot.cable.linear_density": 0.02,
        "robot.cable.diameter": 0.004,
        "robot.frame.lower": [-2.5, -2.5, 0],
        "robot.frame.upper": [2.5, 2.5, 3.5],
        "robot.frame.colour": "#808080",
        "robot.tension.min": 12,
        "robot.tension.max": 480,
    }
    gains = {"controller.kp": [110, 110, 110, 90, 90, 90], "controller.kd": [21, 21, 21, 19, 19, 19]}
    for path, value in {**edits, **gains}.items():
        write(page, path, *(value if isinstance(value, list) else [value]))
    at(page, "robot.frame.shape").select_option(label="posts")
    page.get_by_label("Form of robot, platform, shape").select_option(label="cylinder")
    write(page, "robot.platform.shape.cylinder.radius", 0.35)
    write(page, "robot.platform.shape.cylinder.height", 0.5)
    apply(page)
    assert page.evaluate("cdpr.stage.films[0].anchors[1].slice(0, 3)") == [
        -2.1,
        2,
        3.1,
    ]  # what is drawn is what is said
    page.get_by_role("button", name="Save", exact=True).click()
    page.wait_for_function("() => !cdpr.form.message.modified")

    text = files.robot.read_text()
    robot, scenario = yaml.safe_load(text), yaml.safe_load(files.scenario.read_text())
    for path, value in edits.items():
        assert (
            reduce(lambda node, key: node[int(key) if key.isdigit() else key], re.findall(r"\w+", path)[1:], robot)
            == value
        ), path
    assert robot["platform"]["shape"] == {"cylinder": {"radius": 0.35, "height": 0.5}}
    assert robot["frame"]["shape"] == "posts"
    assert scenario["controller"] == {
        "type": "computed_torque",
        "kp": gains["controller.kp"],
        "kd": gains["controller.kd"],
    }
    for comment in ("# Seven cables, to be edited.", "# kg, as weighed", "# the first", "# the last"):
        assert comment in text
    assert "# stiff enough" in files.scenario.read_text()
    assert cdpr.load_scenario(files.scenario).robot.platform.mass == 21.5


def test_what_is_wrong_stands_under_its_field_and_is_not_applied(page):
    mass = at(page, "robot.platform.mass")
    mass.fill("-5")
    mass.press("Enter")
    told = page.locator('[data-path="robot.platform.mass"] .problem')
    told.wait_for(state="visible")
    assert "greater than 0" in told.inner_text()
    assert mass.get_attribute("aria-invalid") == "true"
    assert mass.input_value() == "-5"  # what was typed stays, to be mended
    assert page.get_by_role("button", name="Apply").is_disabled()
    assert page.get_by_role("tab", name="Robot").locator(".count").inner_text() == "1"
    page.get_by_role("button", name="Undo").click()
    told.wait_for(state="hidden")
    assert mass.input_value() == "20"
    mass.fill("heavy")
    mass.press("Enter")
    told.wait_for(state="visible")
    page.get_by_role("button", name="Revert").click()
    told.wait_for(state="hidden")
    assert mass.input_value() == "20"


def test_a_run_a_push_and_a_cut_are_seen_in_the_plots(page):
    page.get_by_label("Push force, x").fill("40")
    page.get_by_label("Push duration").fill("0.3")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.4")
    page.get_by_role("button", name="Push", exact=True).click()
    page.wait_for_function("() => cdpr.frame.force && cdpr.frame.force[0] === 40")
    page.wait_for_function("() => cdpr.frame.t > 0.9")
    before, pixels = page.evaluate("[cdpr.told.events.children.length, cdpr.curves.plots[0].base.toDataURL()]")
    page.get_by_label("Cable to cut or jam").select_option("cable_7")
    page.get_by_role("button", name="Cut").click()
    page.wait_for_function("() => cdpr.frame.state && cdpr.frame.state[6] === cdpr.data.states.broken")
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function(PHASE, arg="paused")
    page.wait_for_function("(t) => cdpr.curves.latest > 0.9 && !cdpr.waiting")
    page.wait_for_timeout(150)  # ms: the last curves come with the next message
    curves = page.evaluate(
        "cdpr.curves.panels.map(({series}) => series.map(({time, value}) => [Array.from(time), Array.from(value)]))"
    )
    time, error = map(np.array, curves[1][0])
    push, cut = (event["time"] for event in page.evaluate("cdpr.data.events")[:2])
    assert error[(time > push) & (time < cut)].max() > 5 * error[time < push].max()  # mm
    assert page.evaluate("cdpr.curves.plots[0].base.toDataURL()") != pixels
    time, tension = map(np.array, curves[0][6])
    assert tension[time < 0.9].min() > 10 > tension[-1]
    page.get_by_role("tab", name="Events").last.click()
    assert page.locator(".events li").count() > before - 1
    assert "cable_7" in page.locator(".events").inner_text()
    page.get_by_role("tab", name="Numbers").click()
    assert page.locator(".numbers tr", has_text="cable_7").locator(".n").first.inner_text() == "broken"


def test_reset_begins_anew(page):
    page.keyboard.press("Space")
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.keyboard.press("Space")
    page.wait_for_function(PHASE, arg="paused")
    there = page.evaluate("cdpr.frame.t")
    page.keyboard.press(".")
    page.wait_for_function("(t) => cdpr.frame.t > t", arg=there)
    assert page.evaluate("cdpr.frame.t") == pytest.approx(there + 0.001, abs=1e-6)
    page.keyboard.press("r")
    page.wait_for_function(
        "() => cdpr.phase === 'ready' && cdpr.frame?.t === 0 && cdpr.curves.panels[0].series[0].n === 0"
    )


def test_a_saved_session_repeats_what_was_done_to_the_bit(page, files):
    page.get_by_label("Push force, z").fill("30")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_role("button", name="Push", exact=True).click()
    page.get_by_label("Target position, x").fill("0.05")
    page.get_by_role("button", name="Go to the target").click()
    page.wait_for_function("() => cdpr.told.events.querySelectorAll('li:not(.none)').length > 0")
    page.get_by_role("button", name="As fast as it goes").click()
    page.wait_for_function(PHASE, arg="done")
    for button, out in (("Save run…", files.folder / "run"), ("Save session…", files.folder / "session.yaml")):
        page.get_by_role("button", name=button).click()
        dialog = page.locator("dialog[open]")
        dialog.get_by_role("textbox").fill(str(out))
        dialog.get_by_role("button", name="Save").click()
    page.locator(".messages li", has_text="session.yaml").first.wait_for(state="attached")
    seen, again = cdpr.load_run(files.folder / "run"), cdpr.simulate(files.folder / "session.yaml")
    assert np.array_equal(seen.rows, again.rows, equal_nan=True)
    assert seen.position[-1, 0] == pytest.approx(0.05, abs=1e-3)  # not the 0.1 m of the scenario
    assert seen.external[:, 2].max() == 30.0


def test_two_windows_show_the_same(visit):
    one, other = visit(), visit(color_scheme="dark")
    write(one, "robot.platform.mass", 19)
    other.wait_for_function(IS, arg=["robot.platform.mass", 19])
    assert at(other, "robot.platform.mass").input_value() == "19"
    one.get_by_role("button", name="Run", exact=True).click()
    other.wait_for_function("() => cdpr.frame.t > 0.2")
    other.get_by_role("button", name="Pause").click()
    for page in (one, other):
        page.wait_for_function(PHASE, arg="paused")
        page.wait_for_timeout(700)  # ms: the last frame is sent anew while nothing happens
    drawn = [
        page.evaluate("[cdpr.drawn, cdpr.frame.tension, cdpr.curves.panels[0].series[0].n]") for page in (one, other)
    ]
    assert drawn[0] == drawn[1]


@pytest.mark.parametrize(
    "example", ["", "cogiro_pulleys"]
)  # whose cables leave from where they now leave their pulleys
def test_cables_and_platform_are_always_drawn_from_one_row(page, files, example):
    if example:
        page.evaluate("(name) => { cdpr.stage.films[0].before = true; cdpr.send({do: 'open', name}); }", example)
        page.wait_for_function("() => !cdpr.stage.films[0].before && cdpr.phase === 'ready'")
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


def test_a_page_that_is_loaded_again_goes_on_from_where_the_run_is(page):
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.3")
    page.reload()
    page.wait_for_function("() => window.cdpr?.frame?.t > 0.5 && cdpr.curves.panels[0].series[0].time[0] < 0.1")


def test_a_connection_that_is_lost_is_told_and_made_again(page):
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


def test_a_run_that_ends_badly_is_told_and_leaves_the_window_usable(page):
    page.get_by_label("Form of solver").wait_for(state="attached")
    at(page, "solver.infeasible").select_option(label="stop")
    write(page, "robot.tension.max", 60)
    apply(page)
    run_to_the_end(page)
    assert page.locator("#status").get_attribute("class") == "bad"
    assert "no tensions within the limits" in page.locator("#status .text").inner_text()
    write(page, "robot.tension.max", 500)
    apply(page)
    page.get_by_role("button", name="Speed 1", exact=True).click()
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1 && cdpr.phase === 'running'")


def test_the_target_is_dragged_and_the_platform_goes_there(page):
    page.get_by_role("button", name="Run", exact=True).click()
    handle = page.get_by_label("Target of the platform: drag to move it there")
    box = handle.bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y - 20, steps=3)
    page.mouse.up()
    target = page.evaluate("cdpr.handles.target.position")
    page.wait_for_function("(p) => Math.hypot(...p.map((x, i) => x - cdpr.frame.dp[i])) < 0.01", arg=target)


@pytest.mark.parametrize(
    ("handle", "key", "before"),
    [
        ("Anchor of cable 4 on the frame", "frame", [2, 2, 3]),
        ("Point of cable 4 on the platform", "platform", [0.3, 0.3, -0.2]),
    ],
)
def test_a_point_that_is_dragged_is_an_edit(page, handle, key, before):
    page.get_by_role("button", name="points to drag").click()
    page.get_by_label(handle).focus()
    page.keyboard.down("ArrowUp")
    page.keyboard.up("ArrowUp")
    page.wait_for_function("() => !cdpr.form.message.applied")
    moved = np.array(page.evaluate(VALUE, f"robot.cables[3].{key}"))
    assert 0.005 < np.linalg.norm(moved - before) < 0.1
    apply(page)
    ends = page.evaluate("cdpr.stage.films[0].anchors[3]")
    assert ends[:3] + ends[3:] == pytest.approx([*moved, 0.3, 0.3, -0.2] if key == "frame" else [2, 2, 3, *moved])


def test_a_jam_and_an_emergency_stop_act_and_what_is_over_is_disturbed_no_more(page):
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_label("Cable to cut or jam").select_option("cable_2")
    page.get_by_role("button", name="Jam").click()
    page.wait_for_function("() => cdpr.disturb.cable.options[1].text.includes('jammed')")
    page.get_by_role("button", name="Emergency stop").click()
    page.wait_for_function("() => cdpr.data.events.some(({text}) => text.includes('emergency stop'))")
    page.get_by_role("button", name="As fast as it goes").click()
    page.wait_for_function(PHASE, arg="done")
    assert any("'cable_2' jams" in event["text"] for event in page.evaluate("cdpr.data.events"))
    tension, error = (
        np.array(page.evaluate(f"Array.from(cdpr.curves.panels[{k}].series[{i}].value)")) for k, i in ((0, 1), (1, 0))
    )
    assert np.ptp(tension[-5:]) < 1e-3  # it stands still, and what has jammed with it
    assert np.isfinite(error).all()
    for button in ("Push", "Cut", "Set limits", "Go to the target", "Emergency stop"):
        assert page.get_by_role("button", name=button, exact=True).is_disabled()
    assert page.get_by_role("button", name="Save session…").is_enabled()
    page.get_by_role("button", name="Reset").click()
    page.wait_for_function(PHASE, arg="ready")
    assert page.get_by_role("button", name="Push", exact=True).is_enabled()


def test_a_colour_that_is_not_given_is_shown_as_it_is_drawn(page):
    picked = page.get_by_label("robot, platform, colour, picked")
    assert picked.input_value() == page.evaluate("cdpr.data.colours.body[0]").lower()


def test_numbers_of_an_inertia_are_seen_whole(visit):
    page = visit(viewport={"width": 1200, "height": 800})
    write(page, "robot.platform.inertia", 0.866667, 0.866667, 1.234567, 0, 0, 0)
    cut = "(nodes) => nodes.filter((node) => node.scrollWidth > node.clientWidth + 1).length"  # px: both are rounded
    assert page.locator('[data-path="robot.platform.inertia"] input').evaluate_all(cut) == 0


def test_what_does_not_belong_to_a_new_file_cannot_be_filled_in(page):
    page.get_by_role("button", name="New…").click()
    dialog = page.locator("dialog[open]")
    assert dialog.get_by_label("Mass (kg)").is_enabled()
    dialog.get_by_label("Robot of a scenario").fill("seven")
    assert dialog.get_by_label("Mass (kg)").is_disabled()  # it is in the robot's file
    dialog.get_by_label("Kind").select_option("robot")
    assert dialog.get_by_label("Mass (kg)").is_enabled()
    assert dialog.get_by_label("Robot of a scenario").is_disabled()


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


def test_every_control_has_a_name_of_its_own(page):
    while page.evaluate(UNFOLD):
        pass
    names = page.evaluate(NAMES)
    assert len(names) > 100
    assert all(name.strip() for name in names)
    assert [name for name, count in Counter(names).items() if count > 1] == []


PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True, "device_scale_factor": 2}


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


def test_hovering_a_plot_tells_values_and_a_series_can_be_switched_off(page):
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


def test_a_new_robot_from_a_template_is_shown_and_runs(page, files):
    page.evaluate("cdpr.stage.films[0].before = true")
    page.get_by_role("button", name="New…").click()
    dialog = page.locator("dialog[open]")
    dialog.get_by_label("Kind").select_option("robot")
    dialog.get_by_label("File").fill(str(files.folder / "mine.yaml"))
    for name, size in {"width": "4", "depth": "3", "height": "2.5"}.items():
        dialog.get_by_label(f"Frame {name}, m").fill(size)
    dialog.get_by_label("Mass (kg)").fill("12")
    dialog.get_by_role("button", name="Make").click()
    page.wait_for_function("() => !cdpr.stage.films[0].before && cdpr.phase === 'ready'")
    assert page.evaluate(VALUE, "robot.platform.mass") == 12
    assert page.evaluate("cdpr.stage.films[0].cables.length") == 8
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1 && cdpr.frame.tension.every((tension) => tension > 0)")
    page.get_by_role("button", name="YAML").click()
    assert "mass: 12" in page.locator("dialog[open] pre").last.inner_text()


def test_limits_that_change_move_in_the_plot(page):
    assert page.evaluate("cdpr.curves.tension.dashed[0].values") == [10, 500]
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_label("Limits most").fill("140")
    page.get_by_role("button", name="Set limits").click()
    page.wait_for_function("() => String(cdpr.curves.tension.dashed[0].values) === '10,140'")
    page.get_by_label("Limits most").fill("many")
    page.get_by_role("button", name="Set limits").click()
    page.locator(".messages li", has_text="A number is expected").wait_for(state="attached")


def test_a_window_on_a_file_that_is_wrong_shows_why_until_it_is_mended(chromium, files):
    from cdpr.gui.desk import Desk
    from cdpr.gui.window import Window

    files.robot.write_text(ROBOT.replace("mass: 20", "mass: -20"))
    told = []
    with Window(Desk(str(files.scenario)), told.append, port=0) as window, closing(chromium.new_page()) as page:
        window.begin()
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: told.append(str(error)))
        page.goto(window.address)
        page.wait_for_function("() => window.cdpr?.form.message")
        assert "greater than 0" in page.locator('[data-path="robot.platform.mass"] .problem').inner_text()
        page.keyboard.press("Space")  # there is nothing to run, which is told
        page.locator(".messages li").first.wait_for(state="attached")
        write(page, "robot.platform.mass", 20)
        page.get_by_role("button", name="Apply").click()
        page.wait_for_function(READY)
    assert told == []
