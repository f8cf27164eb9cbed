"""The window in a browser jogs winches that take lengths; robots without such winches have no such controls."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT
from window_page import PHASE

import cdpr

pytestmark = pytest.mark.browser

END = 3.35  # m, of a move by 40 mm


@pytest.fixture
def winches(tmp_path):
    """Files of a robot on position servos, long enough for a slow page."""
    folder = ROOT / "scenarios"
    (tmp_path / "camera_robot.yaml").write_text((folder / "robots" / "camera_robot.yaml").read_text())
    text = (folder / "camera_robot.yaml").read_text().replace("robots/camera_robot.yaml", "camera_robot.yaml")
    (tmp_path / "scenario.yaml").write_text(re.sub(r"duration: .*", "duration: 60.0", text, count=1))
    return SimpleNamespace(scenario=tmp_path / "scenario.yaml", folder=tmp_path)


@pytest.mark.usefixtures("files")
class TestWithLengths:
    """Window of the robot on position servos."""

    @pytest.fixture
    def files(self, winches):
        return winches

    def test_a_winch_is_jogged_held_and_given_back(self, page, files):
        controller = page.get_by_role("button", name="Controller", exact=True)
        assert controller.is_disabled()
        page.get_by_role("button", name="Run", exact=True).click()
        page.wait_for_function("() => cdpr.frame.t > 0.1")
        page.get_by_label("Winch to jog").select_option("cable_3")
        page.get_by_label("Jog rate").fill("0.5")
        page.get_by_label("Jog to").fill(str(END))
        page.get_by_role("button", name="Jog", exact=True).click()
        page.wait_for_function(f"() => Math.abs(cdpr.disturb.wound[2].unwound - {END}) < 2e-4")
        assert page.get_by_label("Unwound length").inner_text().startswith("3.3")
        page.get_by_label("Jog rate").fill("-0.02")
        page.get_by_label("Jog to").fill("")
        page.get_by_role("button", name="Jog", exact=True).click()
        page.wait_for_function(f"() => cdpr.disturb.wound[2].unwound < {END} - 5e-3")
        page.get_by_role("button", name="Hold", exact=True).click()
        page.wait_for_function("(t) => cdpr.frame.t > t + 0.3", arg=page.evaluate("cdpr.frame.t"))
        controller.click()
        page.wait_for_function("() => cdpr.disturb.back.disabled")
        page.get_by_role("button", name="Pause").click()
        page.wait_for_function(PHASE, arg="paused")
        page.get_by_role("button", name="Save run…").click()
        dialog = page.locator("dialog[open]")
        dialog.get_by_role("textbox").fill(str(files.folder / "run"))
        dialog.get_by_role("button", name="Save").click()
        page.locator(".messages li", has_text="the run is saved").first.wait_for(state="attached")
        run = cdpr.load_run(files.folder / "run")
        command = run["winch_command"]
        arrived = np.flatnonzero(command[:, 2] == END)
        assert len(arrived) > 5
        moved = np.diff(command[arrived[-1] :, 2])
        held = int(np.flatnonzero(moved == 0.0)[0])
        np.testing.assert_allclose(moved[:held], -0.02 * 0.002, rtol=0, atol=1e-12)  # m in a step
        assert not moved[held : held + 100].any()
        assert np.abs(np.diff(command[arrived[0] : arrived[-1], [0, 1, 3]], axis=0)).max() == 0.0
        assert cdpr.simulate(files.folder / "run" / "session.yaml").rows.tobytes() == run.rows.tobytes()

    def test_a_number_that_is_none_is_marked(self, page):
        page.get_by_label("Jog rate").fill("fast")
        page.get_by_role("button", name="Jog", exact=True).click()
        page.locator(".messages li", has_text="Enter a number").wait_for(state="attached")
        page.get_by_label("Jog rate").fill("")
        page.get_by_role("button", name="Jog", exact=True).click()
        page.locator(".messages li", has_text="its winch takes a rate (m/s)").wait_for(state="attached")


def test_robots_on_torques_have_no_jog(page):
    assert not page.get_by_role("button", name="Jog", exact=True).is_visible()
    assert page.get_by_role("button", name="Push", exact=True).is_visible()
