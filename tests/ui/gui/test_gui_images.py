"""Images of cameras in the messages to windows: each at most once in its period, none without cameras or renderer."""

from __future__ import annotations

from base64 import b64decode

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.log.images import images, png
from cdpr.scenario import load_scenario
from cdpr.sensing import rendering
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.session import SimulationSession

SCENARIO = ROOT / "scenarios" / "camera.yaml"


@pytest.fixture(scope="module", autouse=True)
def usable():
    try:
        rendering.make_renderer("auto", rendering.Lens((100.0, 100.0), (8.0, 8.0), (16, 16))).close()
    except cdpr.CdprError as error:
        pytest.skip(str(error))


def test_images_are_those_of_the_newest_sample_once_per_period():
    scenario, broadcast = load_scenario(SCENARIO), Broadcast()
    session = SimulationSession(scenario, broadcast)
    assert [each["t"] for each in broadcast.latest("images")["cameras"]] == [None, None]
    taken = []
    for _ in range(4):
        session.step(30, session.simulation.step)
        session.show_images()
        taken.append(broadcast.latest("images")["cameras"])
    assert [each[0]["t"] for each in taken] == pytest.approx([0.058, 0.118, 0.118, 0.238])  # 30 samples in 0.06 s
    run = session.simulation.so_far()
    moved = cdpr.simulate(SCENARIO, overrides={"simulation.duration": 0.3, "sensors.0.period": 0.014})
    expected = next(image for time, image in images(moved, "roof") if np.isclose(time, 0.238))
    assert b64decode(taken[-1][0]["png"]) == png(expected)
    assert len(run.rows) == 120
    assert session.about(())["sensors"] == ["markers"]  # those that events can disturb
    session.close()
    later = SimulationSession(load_scenario("caroca"), broadcast)
    assert broadcast.latest("images")["cameras"] == []
    later.close()


def test_a_cable_that_is_cut_is_missing_once_the_events_are_redrawn():
    shown = []
    for redraws in (False, True):
        session = SimulationSession(load_scenario(SCENARIO), broadcast := Broadcast())
        session.simulation.cut(3)
        if redraws:
            session.redraw()
        session.step(1, session.simulation.step)
        session.show_images()
        shown.append(broadcast.latest("images")["cameras"][0]["png"])
        session.close()
    assert shown[0] != shown[1]


def test_without_a_renderer_the_window_reports_it_once(monkeypatch):
    session = SimulationSession(load_scenario(SCENARIO), Broadcast())
    monkeypatch.setattr(rendering, "find_spec", lambda name: None)
    session.step(10, session.simulation.step)
    with pytest.raises(cdpr.CdprError, match="a camera needs mujoco or pybullet"):
        session.show_images()
    session.step(100, session.simulation.step)
    session.show_images()
    session.close()
