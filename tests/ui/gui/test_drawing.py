"""Geometry of the robot in scenes and frames of the window."""

from __future__ import annotations

import numpy as np
from conftest import ROOT
from driver_cases import running_driver

import cdpr
from cdpr.scenario import load_scenario
from cdpr.ui.gui.drawing import Drawing


def test_the_scene_contains_the_rotation_of_the_base():
    """So that a point which is dragged in the world is written as the file has it."""
    turned = {"robot.frame": {"position": [1.0, 0.0, 0.0], "orientation": {"rpy_deg": [20.0, 0.0, 90.0]}}}
    plain, moved = (cdpr.load_scenario("caroca", overrides=changes) for changes in ({}, turned))
    scene = Drawing(moved).scene(moved.initial.state(), moved.desired.sample(0.0))
    base = np.reshape(scene["base"], (3, 3))
    np.testing.assert_allclose(
        plain.robot.anchors[:, :3] @ base.T + [1.0, 0.0, 0.0], np.array(scene["scene"]["anchors"])[:, :3], atol=1e-12
    )


def test_cables_that_leave_from_pulleys_show_where():
    winch = load_scenario(ROOT / "scenarios" / "cogiro_pulleys.yaml")
    with running_driver(winch) as it:
        it.phase("ready")
        it.do("step", n=2)
        it.said()
        frame = it.broadcast.latest("frame")
        assert len(frame["exits"]) == 3 * len(frame["tension"])
        assert all(len(point) == 3 for line in frame["outlines"] for point in line)
