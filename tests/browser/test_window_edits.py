"""The window in a browser edits: what is written, chosen or dragged goes into the files, and what is wrong does not."""

from __future__ import annotations

import re
from functools import reduce

import numpy as np
import pytest
import yaml
from gui_cases import ROBOT
from window_page import DRAWN, IS, VALUE, apply, at, write

import cdpr

pytestmark = pytest.mark.browser


def test_the_confirmation_of_an_earlier_number_does_not_undo_a_later_one(page):
    path = "robot.home.position"
    inputs = at(page, path)
    page.evaluate(
        "() => { window.held = []; window.show = cdpr.form.show.bind(cdpr.form);"
        " cdpr.form.show = (message) => window.held.push(message); }"
    )
    for i, value in enumerate(["0.01", "0.02"]):
        inputs.nth(i).fill(value)
        inputs.nth(i).press("Enter")
    page.wait_for_function("() => window.held.length > 1")
    page.evaluate("window.show(window.held.shift())")
    inputs.nth(2).fill("1.46")
    inputs.nth(2).press("Enter")
    page.evaluate("() => { cdpr.form.show = window.show; for (const message of window.held) window.show(message); }")
    page.wait_for_function(IS, arg=[path, [0.01, 0.02, 1.46]])
    assert [float(inputs.nth(i).input_value()) for i in range(3)] == [0.01, 0.02, 1.46]


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
    assert page.evaluate("cdpr.viewer.films[0].anchors[1].slice(0, 3)") == [
        -2.1,
        2,
        3.1,
    ]  # the drawing matches the text
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


def test_errors_are_shown_at_their_field_and_not_applied(page):
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


def test_a_window_on_a_file_that_is_wrong_shows_why_until_it_is_mended(files, request):
    files.robot.write_text(ROBOT.replace("mass: 20", "mass: -20"))
    page = request.getfixturevalue("visit")("() => window.cdpr?.form.message")
    assert "greater than 0" in page.locator('[data-path="robot.platform.mass"] .problem').inner_text()
    page.keyboard.press("Space")  # no scenario to run, with a message
    page.locator(".messages li").first.wait_for(state="attached")
    write(page, "robot.platform.mass", 20)
    page.get_by_role("button", name="Apply").click()
    page.wait_for_function(DRAWN)


@pytest.mark.parametrize(
    ("handle", "key", "before"),
    [
        ("Anchor of cable 4 on the frame", "frame", [2, 2, 3]),
        ("Point of cable 4 on the platform", "platform", [0.3, 0.3, -0.2]),
    ],
)
def test_a_point_that_is_dragged_is_an_edit(page, handle, key, before):
    page.get_by_role("button", name="Drag points").click()
    page.get_by_label(handle).focus()
    page.keyboard.down("ArrowUp")
    page.keyboard.up("ArrowUp")
    page.wait_for_function("() => !cdpr.form.message.applied")
    moved = np.array(page.evaluate(VALUE, f"robot.cables[3].{key}"))
    assert 0.005 < np.linalg.norm(moved - before) < 0.1
    apply(page)
    ends = page.evaluate("cdpr.viewer.films[0].anchors[3]")
    assert ends[:3] + ends[3:] == pytest.approx([*moved, 0.3, 0.3, -0.2] if key == "frame" else [2, 2, 3, *moved])


def test_a_new_robot_from_a_template_is_shown_and_runs(page, files):
    page.evaluate("cdpr.viewer.films[0].before = true")
    page.get_by_role("button", name="New…").click()
    dialog = page.locator("dialog[open]")
    dialog.get_by_label("Kind").select_option("robot")
    dialog.get_by_label("File").fill(str(files.folder / "mine.yaml"))
    for name, size in {"width": "4", "depth": "3", "height": "2.5"}.items():
        dialog.get_by_label(f"Frame {name}, m").fill(size)
    dialog.get_by_label("Mass (kg)").fill("12")
    dialog.get_by_role("button", name="Create").click()
    page.wait_for_function("() => !cdpr.viewer.films[0].before && cdpr.phase === 'ready'")
    assert page.evaluate(VALUE, "robot.platform.mass") == 12
    assert page.evaluate("cdpr.viewer.films[0].cables.length") == 8
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1 && cdpr.frame.tension.every((tension) => tension > 0)")
    page.get_by_role("button", name="YAML").click()
    assert "mass: 12" in page.locator("dialog[open] pre").last.inner_text()


def test_new_files_reject_unknown_fields(page):
    page.get_by_role("button", name="New…").click()
    dialog = page.locator("dialog[open]")
    assert dialog.get_by_label("Mass (kg)").is_enabled()
    dialog.get_by_label("Robot of a scenario").fill("seven")
    assert dialog.get_by_label("Mass (kg)").is_disabled()  # it is in the robot's file
    dialog.get_by_label("Kind").select_option("robot")
    assert dialog.get_by_label("Mass (kg)").is_enabled()
    assert dialog.get_by_label("Robot of a scenario").is_disabled()
