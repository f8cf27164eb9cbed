"""Drawings of cables that sag: report, still figure, markers of logs and live links, and window."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from sagging_curves import REACHED, integrated

import cdpr
from cdpr.log.header import Header
from cdpr.log.mcap_file import LOG_NAME
from cdpr.log.visuals import SAGGING_PIECES
from cdpr.scene.pictures import FINEST
from cdpr.ui.gui.drawing import CURVE_POINTS, DECIMALS, Drawing
from cdpr.ui.report.figures.sketch import draw
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.scenes import VISIBLE, scene, scene_of_run
from cdpr.ui.report.plots.pictures import frames, pictures_of

SHORT = {"simulation.duration": 0.1, "log.step": 0.05, "robot.cable.linear_density": 0.6}
FLOAT32 = 2e-6  # m: rounding of 20 m in a page


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("sagging") / "run"


@pytest.fixture(scope="module")
def run(folder):
    return cdpr.simulate("sagging", overrides=SHORT, out=folder)


@pytest.fixture(scope="module")
def curves(run):
    """Points of each cable in the last row, from the frame to the platform, (8, k, 3)."""
    robot = cdpr.load_scenario("sagging", overrides=SHORT).robot
    pose = np.concatenate([run.position[-1], run.orientation[-1]])
    return np.array([points[::-1] for _, points in integrated(robot, pose, run["unstretched_length"][-1])])


def spread(curves, count):
    return curves[:, np.linspace(0, curves.shape[1] - 1, count).round().astype(int)]


def old(run):
    """Return the same run in a log of an earlier version, whose header has no spans."""
    plain = run.header.to_dict()
    del plain["spans"]
    return replace(run, header=Header.from_dict(json.loads(json.dumps(plain))))


def test_lines_are_the_curves(run, curves):
    np.testing.assert_allclose(pictures_of(run).cable_lines(11)[-1], spread(curves, 11), atol=REACHED)
    shown = pictures_of(old(run))
    np.testing.assert_array_equal(shown.cable_lines(11), shown.ends)


def test_headers_survive_a_log(run, folder):
    read = cdpr.load_run(folder)
    assert read.header.spans == run.header.spans
    np.testing.assert_array_equal(pictures_of(read).cable_lines(5), pictures_of(run).cable_lines(5))
    assert "spans" not in cdpr.simulate("caroca", overrides={"simulation.duration": 0.01}).header.to_dict()


@pytest.mark.parametrize("tolerance", [0.05, 0.01, 4e-3])
def test_the_fewest_points_that_keep_a_tolerance(run, tolerance):
    shown = pictures_of(run)
    lines, fine = shown.thinned_lines(tolerance), shown.cable_lines(FINEST)

    def apart(kept):
        share = np.linspace(0.0, 1.0, 101)[:, None]
        worst = 0.0
        for cable, thin in zip(fine[-1], kept[-1], strict=True):
            along = np.concatenate([a + share * (b - a) for a, b in pairwise(thin)])
            worst = max(worst, np.linalg.norm(cable[:, None] - along[None], axis=-1).min(axis=1).max())
        return worst

    assert apart(lines) <= tolerance + 1e-5
    assert 3 <= lines.shape[2] < FINEST
    assert apart(lines[:, :, ::2]) > tolerance


def test_scenes_of_reports(run, curves):
    arrays = Arrays()
    made = scene_of_run(run, arrays)
    place = made["curves"]
    data = base64.b64decode(arrays.text())
    points = np.frombuffer(data, "<f4", place["n"], place["at"]).reshape(len(frames(run)), 8, -1, 3)
    count = points.shape[2] + 2
    np.testing.assert_allclose(points[-1], spread(curves, count)[:, 1:-1], atol=FLOAT32)
    tolerance = VISIBLE * np.linalg.norm(np.subtract(*made["bounds"]))
    assert count == pictures_of(run, frames(run)).thinned_lines(tolerance).shape[2]
    assert "curves" not in scene(pictures_of(old(run)), Arrays())


def test_still_figures(run):
    texts = [draw(pictures_of(one)).markup("robot") for one in (run, old(run))]
    numbers = [len(re.findall(r"-?\d+\.?\d*", text)) for text in texts]
    assert numbers[0] > numbers[1] + 200  # cables of many points


def test_markers(run, folder, curves):
    with (folder / LOG_NAME).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        *_, (_, _, _, content) = reader.iter_decoded_messages(["/cdpr/markers"])
    (cables,) = [marker for marker in content.markers if marker.ns == "cables"]
    points = np.array([(p.x, p.y, p.z) for p in cables.points]).reshape(8, SAGGING_PIECES, 2, 3)
    expected = spread(curves, SAGGING_PIECES + 1)
    np.testing.assert_allclose(points[:, :, 0], expected[:, :-1], atol=REACHED)
    np.testing.assert_allclose(points[:, :, 1], expected[:, 1:], atol=REACHED)
    shades = np.array([(c.r, c.g, c.b, c.a) for c in cables.colors]).reshape(8, 2 * SAGGING_PIECES, 4)
    assert (shades == shades[:, :1]).all()
    assert len(np.unique(shades[:, 0], axis=0)) > 2


def test_frames_of_the_window(run, curves):
    drawing = Drawing(cdpr.load_scenario("sagging", overrides=SHORT))
    frame = drawing.frame(100, run.rows[-1])
    points = np.reshape(frame["curves"], (8, CURVE_POINTS - 2, 3))
    shown = pictures_of(run).cable_lines(CURVE_POINTS)[-1, :, 1:-1]
    np.testing.assert_allclose(points, shown, atol=0.6 * 10.0**-DECIMALS)
    middle = points[:, CURVE_POINTS // 2 - 1]
    np.testing.assert_allclose(middle, curves[:, curves.shape[1] // 2], atol=0.6 * 10.0**-DECIMALS + REACHED)
