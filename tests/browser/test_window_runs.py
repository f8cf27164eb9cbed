"""The window in a browser runs and disturbs: pushes, cuts, targets, limits, and what is saved of it."""

from __future__ import annotations

import numpy as np
import pytest
from window_page import PHASE, apply, at, run_to_the_end, write

import cdpr

pytestmark = pytest.mark.browser


def test_a_run_a_push_and_a_cut_are_seen_in_the_plots(page):
    page.get_by_label("Push force, x").fill("40")
    page.get_by_label("Push duration").fill("20")  # s: to be seen also by a page that draws twice a second
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.4")
    page.get_by_role("button", name="Push", exact=True).click()
    page.wait_for_function("() => cdpr.frame.force && cdpr.frame.force[0] === 40")
    page.wait_for_function("() => cdpr.frame.t > 0.9")
    before, pixels = page.evaluate("[cdpr.output.events.children.length, cdpr.curves.plots[0].base.toDataURL()]")
    page.get_by_label("Cable to cut or jam").select_option("cable_7")
    page.get_by_role("button", name="Cut").click()
    page.wait_for_function("() => cdpr.frame.state && cdpr.frame.state[6] === cdpr.data.states.broken")
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function(PHASE, arg="paused")
    page.wait_for_function("(t) => cdpr.curves.latest > 0.9 && !cdpr.waiting")
    page.wait_for_function("() => cdpr.curves.panels[0].series[6].value.at(-1) < 10")  # comes with the next message
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


def test_a_jam_and_an_emergency_stop_act_and_what_is_over_is_disturbed_no_more(page):
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_label("Cable to cut or jam").select_option("cable_2")
    page.get_by_role("button", name="Jam").click()
    page.wait_for_function("() => cdpr.disturb.cable.options[1].text.includes('jammed')")
    page.get_by_role("button", name="Emergency stop").click()
    page.wait_for_function("() => cdpr.data.events.some(({text}) => text.includes('emergency stop'))")
    page.get_by_role("button", name="Maximum speed").click()
    page.wait_for_function(PHASE, arg="done")
    assert any("'cable_2' jams" in event["text"] for event in page.evaluate("cdpr.data.events"))
    tension, error = (
        np.array(page.evaluate(f"Array.from(cdpr.curves.panels[{k}].series[{i}].value)")) for k, i in ((0, 1), (1, 0))
    )
    assert np.ptp(tension[-5:]) < 1e-3  # it is paused, and so are jammed cables
    assert np.isfinite(error).all()
    for button in ("Push", "Cut", "Set limits", "Go to the target", "Emergency stop"):
        assert page.get_by_role("button", name=button, exact=True).is_disabled()
    assert page.get_by_role("button", name="Save session…").is_enabled()
    page.get_by_role("button", name="Reset").click()
    page.wait_for_function(PHASE, arg="ready")
    assert page.get_by_role("button", name="Push", exact=True).is_enabled()


def test_limits_that_change_move_in_the_plot(page):
    assert page.evaluate("cdpr.curves.tension.dashed[0].values") == [10, 500]
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_label("Tension max", exact=True).fill("140")
    page.get_by_role("button", name="Set limits").click()
    page.wait_for_function("() => String(cdpr.curves.tension.dashed[0].values) === '10,140'")
    page.get_by_label("Tension max", exact=True).fill("many")
    page.get_by_role("button", name="Set limits").click()
    page.locator(".messages li", has_text="Enter a number").wait_for(state="attached")


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


def test_a_run_that_ends_badly_is_reported_and_leaves_the_window_usable(page):
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


def test_a_saved_session_repeats_what_was_done_to_the_bit(page, files):
    page.get_by_label("Push force, z").fill("30")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_role("button", name="Push", exact=True).click()
    page.get_by_label("Target position, x").fill("0.05")
    page.get_by_role("button", name="Go to the target").click()
    page.wait_for_function("() => cdpr.output.events.querySelectorAll('li:not(.none)').length > 0")
    page.get_by_role("button", name="Maximum speed").click()
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


def test_a_payload_is_attached_and_released(page):
    page.get_by_label("Payload mass").fill("20")
    page.get_by_label("Payload center, z").fill("-0.2")
    page.get_by_label("known").check()
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.2")
    page.get_by_role("button", name="Attach").click()
    page.get_by_role("button", name="Release 20 kg").wait_for()
    told = page.evaluate("cdpr.data.events.at(-1).text")
    assert told == "payload of 20 kg at [0, 0, -0.2] m, known to the controller"
    page.wait_for_function("(t) => cdpr.frame.t > t + 0.05", arg=page.evaluate("cdpr.frame.t"))
    page.get_by_role("button", name="Release 20 kg").click()
    page.get_by_role("button", name="Release 20 kg").wait_for(state="detached")


def test_a_sensor_is_occluded_bumped_and_fails(page):
    group = page.get_by_role("group", name="Sensor")
    assert not group.is_visible()  # the scenario has none
    page.evaluate("['pose', 'twist', 'pose'].forEach((type) => cdpr.form.insert('sensors', type))")
    page.wait_for_function("() => document.querySelector('[data-path=\"sensors[2].name\"]')", timeout=20_000)
    apply(page)
    assert page.get_by_label("Sensor to disturb").locator("option").all_inner_texts() == ["pose", "twist", "pose_2"]
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => cdpr.frame.t > 0.1")
    page.get_by_label("Sensor to disturb").select_option("pose_2")
    page.get_by_label("Occlusion time").fill("0.2")
    page.get_by_label("Sensor bias").fill("0.02")
    for name in ("Occlude", "Bump", "Fail"):
        group.get_by_role("button", name=name).click()
    page.wait_for_function("() => cdpr.data.events.filter(({text}) => text.includes('pose_2')).length === 3")
    assert [event["text"] for event in page.evaluate("cdpr.data.events")][-3:] == [
        "sensor 'pose_2' is occluded",
        "sensor 'pose_2' is bumped: bias +0.02",
        "sensor 'pose_2' fails",
    ]
