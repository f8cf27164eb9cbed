"""Pictures in a log, and layouts for Foxglove and PlotJuggler."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import ROOT
from log_cases import make_header, make_rows, write_log
from log_topics import FULL_RATE, PICTURES, wxyz, xyz
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore

from cdpr import load_scenario
from cdpr.log.reader import load_run
from cdpr.model import rotations
from cdpr.scene import colours
from cdpr.scene.pictures import weight_range


def test_pictures(tmp_path: Path) -> None:
    header = make_header(3)
    rows = make_rows(header, 300)
    columns = header.layout.columns
    rows[34, columns["tension"]] = [1.0, 50.5, 1000.0]
    decoded: dict[str, dict[int, Any]] = {topic: {} for topic in PICTURES}
    with write_log(tmp_path / "log.mcap", header, rows).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages(list(PICTURES)):
            decoded[channel.topic][message.sequence] = content
    assert list(decoded["/tf"]) == list(decoded["/clock"]) == list(range(0, 300, 17))  # at most 60 Hz
    assert [clock.clock.sec * 10**9 + clock.clock.nanosec for clock in decoded["/clock"].values()] == [
        k * 1_000_000 for k in decoded["/clock"]
    ]
    assert list(decoded["/cdpr/markers"]) == list(range(0, 300, 34))
    (transform,) = decoded["/tf"][34].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "platform")
    assert transform.header.stamp.nanosec == 34_000_000
    assert xyz(transform.transform.translation) == rows[34, columns["position"]].tolist()
    assert wxyz(transform.transform.rotation) == rows[34, columns["orientation"]].tolist()
    cables, platform = decoded["/cdpr/markers"][34].markers
    assert (cables.type, platform.type, cables.ns, platform.ns) == (5, 1, "cables", "platform")
    assert xyz(platform.scale) == [0.4, 0.3, 0.2]
    assert cables.header.stamp.nanosec == platform.header.stamp.nanosec == 34_000_000
    assert xyz(platform.pose.position) == rows[34, columns["position"]].tolist()
    assert wxyz(platform.pose.orientation) == rows[34, columns["orientation"]].tolist()
    points = np.array([xyz(point) for point in cables.points]).reshape(3, 2, 3)
    anchors = np.array(header.anchors)
    R = rotations.matrix(rows[34, columns["orientation"]])
    np.testing.assert_array_equal(points[:, 0], anchors[:, :3])
    placed = rows[34, columns["position"]] + anchors[:, 3:] @ R.T
    np.testing.assert_allclose(points[:, 1], placed, rtol=1e-12, atol=1e-9)
    found = [[c.r, c.g, c.b, c.a] for c in cables.colors]
    low, high = weight_range(header.subject, header.mass * float(np.linalg.norm(header.gravity)))
    middle = colours.tension_colours(np.array([np.log(50.5 / low) / np.log(high / low)]))[0]
    limit = [*colours.parts(colours.LIMIT.dark), 1.0]
    expected = [limit] * 2 + [[*middle, 1.0]] * 2 + [limit] * 2
    assert found == [pytest.approx(colour, abs=1e-6) for colour in expected]


def test_the_desired_path_and_pose_are_drawn_too(tmp_path: Path) -> None:
    """And logs of earlier versions, which have neither, stay whole: their headers hold no path."""
    path = ((0.0, 0.0, 1.0), (0.5, 0.0, 1.0), (0.5, 0.25, 1.5))
    header = replace(make_header(3), path=path)
    rows = make_rows(header, 3000)
    log = write_log(tmp_path / "log.mcap", header, rows)
    with log.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        lines = [content.markers for *_, content in reader.iter_decoded_messages(["/cdpr/desired_path"])]
    with log.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        *_, drawn = next(iter(reader.iter_decoded_messages(["/cdpr/markers"])))
    assert len(lines) == 3  # one a second
    assert [tuple(xyz(point)) for point in lines[0][0].points] == list(path)
    *_, ghost = drawn.markers
    assert ghost.ns == "desired"
    assert xyz(ghost.pose.position) == rows[0, header.layout.columns["desired_position"]].tolist()
    assert load_run(log).header.path == path
    assert "path" not in make_header(3).to_dict()


def test_the_foxglove_layout_matches_a_log() -> None:
    layout = json.loads((ROOT / "docs" / "foxglove.json").read_text())
    panels = layout["configById"]
    assert set(re.findall(r'"([A-Za-z0-9]+![a-z_]+)"', json.dumps(layout["layout"]))) == set(panels)
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", ())]
    topics = [topic for panel in panels.values() for topic in panel.get("topics", ())]
    known = {**FULL_RATE, **PICTURES, "/cdpr/desired_path": "visualization_msgs/msg/MarkerArray"}
    store = get_typestore(Stores.LATEST)
    assert set(topics) <= set(known)
    assert paths
    for path in paths:
        topic, *fields = re.sub(r"\[\d+\]|\.@\w+", "", path).split(".")
        kind = known[topic]
        for field in fields:
            names = dict(store.fielddefs[kind][1])
            assert field in names, path
            node, inside = names[field]
            kind = inside if node.name == "NAME" else ""


def test_the_plotjuggler_layout_matches_a_log() -> None:
    root = ElementTree.parse(ROOT / "docs" / "plotjuggler.xml").getroot()
    series = [curve.attrib["name"] for curve in root.iter("curve")]
    cables = [cable.name for cable in load_scenario(ROOT / "scenarios" / "caroca.yaml").robot.cables]
    store = get_typestore(Stores.LATEST)
    assert len(series) > 20
    for name in series:
        topic = next(known for known in FULL_RATE if name.startswith(f"{known}/"))
        fields = name.removeprefix(f"{topic}/").split("/")
        kind = FULL_RATE[topic]
        if kind == "sensor_msgs/msg/JointState":  # there a series is named after the joint
            cable, *fields = fields
            assert cable in cables
        for field in fields:
            node, inside = dict(store.fielddefs[kind][1])[field]
            kind = inside if node.name == "NAME" else ""
    for splitter in root.iter("DockSplitter"):
        assert len(splitter) == int(splitter.attrib["count"]) == len(splitter.attrib["sizes"].split(";"))


def test_odd_values_are_drawn_without_complaint(tmp_path: Path) -> None:
    header = make_header(2, tension_min=(5.0, 0.0), tension_max=(5.0, float("inf")))
    rows = make_rows(header, 80)
    rows[34:, 1:] = np.nan
    rows[68:, 1:] = 1e300
    path = write_log(tmp_path / "log.mcap", header, rows)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        drawn = [content for _, _, _, content in reader.iter_decoded_messages(["/cdpr/markers"])]
    assert len(drawn) == 3
    for content in drawn:
        assert all(0.0 <= part <= 1.0 for c in content.markers[0].colors for part in (c.r, c.g, c.b, c.a))
