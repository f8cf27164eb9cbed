"""Plots of the estimate in a report: legends of bands, and robots whose platform cannot turn."""

from __future__ import annotations

import pytest
from browser_pages import READY
from conftest import ROOT

import cdpr
from cdpr.ui.report.pages.run import write_report

pytestmark = pytest.mark.browser

SENSORS = [{"type": "pose"}, {"type": "twist"}]
SHORT = {"simulation.duration": 0.05, "sensors": SENSORS, "estimator.type": "ekf"}
LEGENDS = """() => Object.fromEntries([...document.querySelectorAll("#estimate .plot")].map((plot) => [
  plot.querySelector(".label").textContent,
  [...plot.querySelectorAll(".series button span")].map((each) => each.textContent),
]))"""
TURNS = "attitude", "angular", "rotation", "orient"


@pytest.mark.parametrize("name", ["caroca", "point_mass"])
def test_bands_have_one_entry_and_points_no_rotations(name, open_page, tmp_path):
    run = cdpr.simulate(ROOT / "scenarios" / f"{name}.yaml", overrides=SHORT)
    write_report(run, tmp_path / "report.html")
    page = open_page((tmp_path / "report.html").as_uri())
    page.wait_for_function(READY, polling=50)
    legends = page.evaluate(LEGENDS)
    assert legends["error of position (m)"] == ["x", "y", "z", "±3 σ"]
    labels = page.evaluate("[...document.querySelectorAll('.plot .label')].map((each) => each.textContent)")
    labels = [label for label in labels if "pose_" not in label and "twist_" not in label]
    assert any(word in label for label in labels for word in TURNS) == (name == "caroca")
    band = page.locator("#estimate .series button", has_text="±3 σ").first
    band.click()
    assert band.get_attribute("aria-pressed") == "false"
