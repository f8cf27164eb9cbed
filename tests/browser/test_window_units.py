"""The window in a browser: degrees for hands and radians for files, changes that are not lost, messages that stay."""

from __future__ import annotations

import math

import pytest
import yaml
from window_page import VALUE, apply, at, run_to_the_end, write

pytestmark = pytest.mark.browser

START = """
initial:
  position: [0, 0, 1.5]
  orientation: {rpy: [0.3, 0, 0.1]}
"""
RPY = "initial.orientation.rpy"


@pytest.fixture
def files(files):
    files.scenario.write_text(files.scenario.read_text() + START.lstrip())
    return files


def wait_for(page, path, check):
    page.wait_for_function(f"(path) => {{ const v = ({VALUE})(path); return {check}; }}", arg=path)


def test_attitudes_are_degrees_in_the_form_and_radians_in_the_file(page, files):
    page.evaluate("(path) => cdpr.form.lead(path, 'motion')", RPY)
    inputs = page.locator(f'[data-path="{RPY}"]').first.locator("input")
    shown = [float(inputs.nth(i).input_value()) for i in range(3)]
    assert shown == pytest.approx([math.degrees(0.3), 0.0, math.degrees(0.1)], rel=1e-9)
    assert page.locator(f'[data-path="{RPY}"] .unit').first.inner_text() == "deg"
    inputs.nth(2).fill("30")
    inputs.nth(2).press("Enter")
    wait_for(page, RPY, "Math.abs(v[2] - Math.PI / 6) < 1e-9")
    assert float(inputs.nth(2).input_value()) == 30.0
    page.get_by_role("button", name="Save", exact=True).click()
    page.wait_for_function("() => !cdpr.form.message.modified")
    saved = yaml.safe_load(files.scenario.read_text())["initial"]["orientation"]["rpy"]
    assert saved[0] == 0.3  # what was not changed stays to the bit
    assert saved[2] == pytest.approx(math.radians(30), abs=1e-11)


def test_the_target_is_in_degrees_as_the_attitude_beside_it(page):
    sent = """() => { window.sent = []; const send = cdpr.link.send.bind(cdpr.link);
        cdpr.link.send = (message, files) => { window.sent.push(message); return send(message, files); }; }"""
    page.evaluate(sent)
    page.get_by_label("Target rpy, yaw").fill("10")
    page.get_by_role("button", name="Go to the target").click()
    (target,) = [each for each in page.evaluate("window.sent") if each["do"] == "target"]
    assert target["rpy"] == pytest.approx([0.0, 0.0, math.radians(10)], abs=1e-9)
    page.get_by_role("button", name="Here", exact=True).click()
    assert float(page.get_by_label("Target rpy, roll").input_value()) == pytest.approx(math.degrees(0.3), abs=0.01)


@pytest.mark.parametrize("answer", ["Save", "Discard", "Cancel"])
def test_open_requires_a_decision_on_unsaved_changes(page, files, answer):
    before = files.robot.read_text()
    write(page, "robot.platform.mass", 21.5)
    page.get_by_role("button", name="Open…").click()
    dialog = page.locator("dialog[open]")
    dialog.get_by_label("Name or path").fill("planar")
    dialog.get_by_role("button", name="Open").click()
    page.get_by_role("dialog", name="Unsaved changes").get_by_role("button", name=answer, exact=True).click()
    if answer == "Cancel":
        page.wait_for_timeout(300)
        assert page.evaluate(f"({VALUE})('robot.platform.mass')") == 21.5
    else:
        page.wait_for_function("() => document.getElementById('file').textContent.includes('planar')")
    assert (files.robot.read_text() == before) is (answer != "Save")


def ask_new(page, files):
    page.get_by_role("button", name="New…").click()
    dialog = page.locator("dialog[open]")
    dialog.get_by_label("File").fill(str(files.folder / "fresh.yaml"))
    dialog.get_by_role("button", name="Create").click()


def ask_import(page, files):
    page.get_by_role("button", name="Import…").click()


WAYS = {
    "New": (ask_new, "() => document.getElementById('file').textContent.includes('fresh')"),
    "Import": (ask_import, "() => document.querySelector('dialog[open] h2')?.textContent.startsWith('Import')"),
}


@pytest.mark.parametrize("answer", ["Save", "Discard", "Cancel"])
@pytest.mark.parametrize("way", WAYS)
def test_new_and_import_require_a_decision_on_unsaved_changes(page, files, way, answer):
    before, (begin, done) = files.robot.read_text(), WAYS[way]
    write(page, "robot.platform.mass", 21.5)
    begin(page, files)
    page.get_by_role("dialog", name="Unsaved changes").get_by_role("button", name=answer, exact=True).click()
    if answer == "Cancel":
        page.wait_for_timeout(300)
        assert page.evaluate(f"({VALUE})('robot.platform.mass')") == 21.5
        assert not page.evaluate("document.querySelector('dialog[open]') !== null")
    else:
        page.wait_for_function(done)
    assert (files.robot.read_text() == before) is (answer != "Save")


def test_speeds_of_drums_stay_in_radians(page):
    page.evaluate("cdpr.send({ do: 'open', name: 'winch' })")
    field = page.locator('[data-path="robot.winch.coulomb_speed"]').first
    field.wait_for(state="attached")
    assert field.locator(".unit").text_content() == "rad/s"


def test_open_without_changes_needs_no_decision(page):
    page.get_by_role("button", name="Open…").click()
    dialog = page.locator("dialog[open]")
    dialog.get_by_label("Name or path").fill("planar")
    dialog.get_by_role("button", name="Open").click()
    page.wait_for_function("() => document.getElementById('file').textContent.includes('planar')")


def test_the_stop_reason_stays_in_the_messages(page):
    page.get_by_label("Form of solver").wait_for(state="attached")
    at(page, "solver.infeasible").select_option(label="stop")
    write(page, "robot.tension.max", 60)
    apply(page)
    run_to_the_end(page)
    told = page.locator(".messages li.bad", has_text="no tensions within the limits")
    told.first.wait_for(state="visible")
    assert told.count() == 1
