"""Appearance and base of a robot: shapes, meshes, frames, colours, and their drawing."""

from __future__ import annotations

import os
import struct

import numpy as np
import pytest
from conftest import ROOT
from log_cases import make_header, make_rows, write_log
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scenario_cases import BASE, load, problem

import cdpr
from cdpr import Simulation, load_run, simulate
from cdpr.base.files import UnreadableError
from cdpr.log.header import Header
from cdpr.model import Box, Cylinder, Mesh, Sphere, rotations
from cdpr.scenario import load_robot, load_scenario, mesh
from cdpr.scene import Subject, pictures
from cdpr.ui.report.figures.sketch import draw

CAROCA = ROOT / "scenarios" / "caroca.yaml"
ROBOT = ROOT / "scenarios" / "robots" / "caroca.yaml"
CORNERS = [(0.0, 0.0, -0.5), (1.0, 0.25, 0.0), (0.5, -0.75, 0.125)]  # exact in single precision
AROUND = ((0.0, -0.75, -0.5), (1.0, 0.25, 0.125))

MARK = b"\xef\xbb\xbf"

ROUND_OFF = 1e-12  # of coordinates of some metres
# Two runs whose numbers differ by round-off from the first sample on, for 0.3 s under control; measured 2e-11 N.
TENSIONS = 1e-8


def binary(corners):
    triangle = struct.pack("<3f", 0, 0, 1) + b"".join(struct.pack("<3f", *corner) for corner in corners) + b"\0\0"
    return b"made by hand".ljust(80) + struct.pack("<I", 2) + 2 * triangle


def text(corners):
    rows = "".join("      vertex {} {} {}\n".format(*corner) for corner in corners)
    return f"solid tool\n  facet normal 0 0 1\n    outer loop\n{rows}    endloop\n  endfacet\nendsolid\n".encode()


def obj(corners):
    rows = "".join("v {} {} {}\n".format(*corner) for corner in corners)
    return f"# a comment\n{rows}vn 0 0 1\nvt 9 9\nf 1//1 2//1 3//1\n".encode()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", binary(CORNERS)),
        ("a.stl", b"solid tool".ljust(80) + binary(CORNERS)[80:]),
        ("b.STL", text(CORNERS)),
        ("b.stl", MARK + text(CORNERS)),
        ("b.stl", text(CORNERS).upper().replace(b"\n", b"\r\n")),
        ("c.obj", obj(CORNERS)),
        ("c.obj", MARK + obj(CORNERS)),
        (
            "c.obj",
            obj(CORNERS).replace(b"v ", b"V ").replace(b" 0.25", b" \\\n  0.25").replace(b" -0.75", b"\\\r\n -0.75"),
        ),
        ("d.stl", text(CORNERS * 20)),
    ],
)
def test_the_box_around_a_mesh(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    assert mesh.box_around(str(tmp_path / name)) == AROUND


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.stl", binary(CORNERS)[:-1], "expected binary STL of the declared length, or text that begins with"),
        ("a.stl", b"", "expected binary STL"),
        ("a.stl", b"solid nothing\nendsolid\n", "it has no vertices"),
        ("a.stl", text(CORNERS)[:-12], "it is text that does not end with 'endsolid'"),
        (
            "a.stl",
            (b"solid tool".ljust(80) + binary(CORNERS)[80:])[:-9],
            "not a binary STL of 184 bytes, as its 2 declared triangles",
        ),
        ("a.stl", b"solid tool".ljust(80, b"\0"), "is not a binary STL: it has 80 bytes"),
        ("a.stl", text([(0.0, 0.0, "1_0")]), "expected three numbers after 'vertex' in line 4"),
        ("a.obj", b"v 1 2_0 3\n", "expected three numbers after 'v' in line 1"),
        ("a.obj", b"v 0 0 0\nv 1 2 \\\n", "expected three numbers after 'v' in line 2"),
        ("a.stl", text([(0.0, 0.0, "x")]), "expected three numbers after 'vertex' in line 4"),
        ("a.obj", b"v 1 2\n", "expected three numbers after 'v' in line 1"),
        ("a.obj", obj([(0.0, 0.0, float("nan"))]), "a corner is not finite"),
        ("a.stl", binary([(1e30, 0, 0)] * 3), "a corner is not finite or beyond 1e+06 m"),
        ("a.obj", b"v 0 0 0\n" * 20, "is larger than"),
        ("a.ply", b"ply\n", "expected a mesh file that ends with .stl or .obj"),
    ],
)
def test_invalid_meshes_are_reported(tmp_path, monkeypatch, name, content, told):
    if "larger" in told:
        monkeypatch.setattr(mesh, "MAX_BYTES", 100)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UnreadableError, match=r"a\.(stl|obj|ply)") as refused:
        mesh.box_around(str(tmp_path / name))
    assert told in str(refused.value)


def test_a_mesh_that_changes_is_read_again(tmp_path):
    path = tmp_path / "a.obj"
    path.write_bytes(obj(CORNERS))
    assert mesh.box_around(str(path)) == AROUND
    path.write_bytes(obj([*CORNERS, (2.0, 0.0, 0.0)]))
    assert mesh.box_around(str(path))[1][0] == 2.0


@pytest.mark.parametrize(
    ("given", "shape"),
    [
        ("{box: [1, 2, 3]}", Box((1, 2, 3))),
        ("{sphere: 0.5}", Sphere(0.5)),
        ("{cylinder: {radius: 0.5, height: 2}}", Cylinder(0.5, 2)),
    ],
)
def test_shapes(given, shape):
    robot = load_robot(str(ROBOT), overrides=[f"platform.shape={given}", "platform.colour=orange"])
    assert robot.platform.shape == shape
    assert (robot.platform.colour, robot.colours) == ("#ffa500", {"platform": "#ffa500"})


def test_a_mesh_lies_beside_the_file_that_names_it(tmp_path):
    """In a robot file beside that, on the command line beside the scenario; also in what is resolved."""
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "tool.stl").write_bytes(binary(CORNERS))
    (tmp_path / "other.obj").write_bytes(obj([(1, 2, 3)]))
    robot = ROBOT.read_text().replace("{box: [1.2, 0.6, 0.4]}", "{mesh: tool.stl}")
    (tmp_path / "robots" / "caroca.yaml").write_text(robot)
    (tmp_path / "s.yaml").write_text(CAROCA.read_text())
    scenario = load_scenario(str(tmp_path / "s.yaml"))
    assert scenario.robot.platform.outline == {"mesh": [list(corner) for corner in AROUND]}
    assert isinstance(load_robot(str(tmp_path / "robots" / "caroca.yaml")).platform.shape, Mesh)
    again = load_scenario(str(tmp_path / "s.yaml"), text=scenario.resolved_yaml())
    assert again.robot.platform.outline == scenario.robot.platform.outline
    assert again == scenario
    changed = scenario.with_changes({"robot.platform.shape.mesh": "other.obj"})
    assert changed.robot.platform.shape.lower == (1, 2, 3)


def test_a_run_folder_names_the_same_files_as_its_scenario(tmp_path):
    """It lies elsewhere: a mesh, a table and an event's file are found from there, and the run repeats to the bit."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "tool.stl").write_bytes(binary(CORNERS))
    (tmp_path / "robot.yaml").write_text(ROBOT.read_text().replace("{box: [1.2, 0.6, 0.4]}", "{mesh: parts/tool.stl}"))
    (tmp_path / "path.csv").write_text("t,x,y,z\n0,0,0,1.2\n0.05,0,0,1.25\n")
    (tmp_path / "s.yaml").write_text(
        "robot: robot.yaml\ninitial: {position: [0, 0, 1.2]}\nsimulation: {duration: 0.02}\n"
        "trajectory: {type: csv, file: path.csv}\n"
    )
    with Simulation(tmp_path / "s.yaml") as sim:
        sim.step(5, wrench=[0, 0, 1500, 0, 0, 0])
        while not sim.done:
            sim.step()
        sim.save(tmp_path / "session.yaml")
    first = simulate(tmp_path / "session.yaml", out=tmp_path / "deep" / "er" / "run")
    written = tmp_path / "deep" / "er" / "run" / "scenario.yaml"
    again = simulate(written, out=tmp_path / "again")
    assert np.array_equal(first.rows, again.rows)
    assert load_scenario(written).robot.platform.outline == {"mesh": [list(corner) for corner in AROUND]}
    assert load_run(tmp_path / "again").header.scenario_yaml == again.header.scenario_yaml
    assert load_scenario(tmp_path / "again" / "scenario.yaml").trajectory.file == "../path.csv"
    moved = tmp_path / "elsewhere" / "session.yaml"
    moved.parent.mkdir()
    with Simulation(tmp_path / "s.yaml") as sim:
        sim.step(2)
        sim.save(moved)
    assert load_scenario(moved).robot.platform.outline == {"mesh": [list(corner) for corner in AROUND]}


def test_a_run_folder_beyond_a_link_names_the_same_files(tmp_path):
    """`..` leads upwards from where a link leads: of the run's folder, and of the scenario's."""
    for name in ("far/away", "near"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "link").symlink_to("far/away")
    (tmp_path / "far" / "back").symlink_to("../near")
    (tmp_path / "near" / "tool.stl").write_bytes(binary(CORNERS))
    changes = {"robot.platform.shape": {"mesh": "tool.stl"}}
    (tmp_path / "near" / "robot.yaml").write_text(ROBOT.read_text())
    (tmp_path / "near" / "s.yaml").write_text(
        "robot: robot.yaml\ninitial: {position: [0, 0, 1.2]}\nsimulation: {duration: 0.02}\n"
    )
    scenario = load_scenario(tmp_path / "far" / "back" / "s.yaml", overrides=changes)
    (tmp_path / "link" / "again.yaml").write_text(scenario.yaml_in(str(tmp_path / "link")))
    assert load_scenario(tmp_path / "link" / "again.yaml").robot.platform.outline == scenario.robot.platform.outline


@pytest.mark.parametrize("good", [binary(CORNERS), text(CORNERS), obj(CORNERS)], ids=["binary", "text", "obj"])
def test_any_bytes_are_a_mesh_or_an_error(tmp_path, good):
    """Cut, bytes changed, lines repeated: a finite box or one sentence."""
    rng = np.random.default_rng(0)
    for k in range(400):
        content = bytearray(good[: rng.integers(len(good)) if k % 4 == 0 else None])
        for place in rng.integers(max(len(content), 1), size=min(len(content), k % 3)):
            content[place] = rng.integers(256)
        path = tmp_path / f"{k}{'.obj' if good.startswith(b'#') else '.stl'}"
        path.write_bytes(bytes(content))
        told = ""
        try:
            lower, upper = mesh.box_around(str(path))
        except UnreadableError as error:
            told = str(error)
        if told:
            assert "is not a mesh: " in told
            assert told.isprintable()
        else:
            assert np.isfinite([lower, upper]).all()
            assert (np.array(lower) <= upper).all()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("robot.platform.shape={}", "robot.platform.shape: expected exactly one of box, sphere, cylinder, mesh"),
        (
            "robot.platform.shape={box: [1, 1, 1], sphere: 1}",
            "robot.platform.shape: expected exactly one of box, sphere,",
        ),
        (
            "robot.platform.shape={cylinder: {radius: 1}}",
            "robot.platform.shape.cylinder.height: required but not",
        ),
        ("robot.platform.shape={mesh: none.stl}", "robot.platform.shape.mesh: there is no file 'none.stl'"),
        (
            "robot.platform.shape={mesh: /none.stl}",
            "robot.platform.shape.mesh: expected a file name relative to this file",
        ),
        (
            "robot.platform.colour=beige",
            "robot.platform.colour: expected a colour, '#rrggbb' or one of black",
        ),
        ("robot.frame={colour: '#12345'}", "robot.frame.colour: expected a colour"),
        (
            "robot.frame={lower: [0, 0, 3], upper: [1, 1, 2]}",
            "robot.frame: z of lower (3 m) must not exceed that of",
        ),
        ("robot.frame={shape: poles}", "robot.frame.shape: expected one of box, posts, got 'poles'"),
        ("robot.frame={size: 3}", "robot.frame.size: unknown key 'size'"),
    ],
)
def test_mistakes_are_reported(change, told):
    assert problem(BASE, change).startswith(f"--set {change}: {told}")


def test_no_fifo_is_opened_as_a_mesh(tmp_path):
    os.mkfifo(tmp_path / "a.stl")
    with pytest.raises(UnreadableError, match="is not a regular file"):
        mesh.box_around(str(tmp_path / "a.stl"))


def test_a_base_moves_anchors_and_home_alone():
    plain = load_robot(str(ROBOT))
    changes = {"frame": {"position": [2.0, -1.0, 0.5], "orientation": {"rpy": [0.0, 0.0, 0.5 * np.pi]}}}
    robot = load_robot(str(ROBOT), overrides=changes)
    x, y, z = plain.anchors[:, :3].T
    assert np.abs(robot.anchors[:, :3] - np.stack([2.0 - y, -1.0 + x, 0.5 + z], axis=1)).max() < ROUND_OFF
    assert np.array_equal(robot.anchors[:, 3:], plain.anchors[:, 3:])
    assert robot.home == pytest.approx([2.0, -1.0, 1.7, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    still = load_robot(str(ROBOT), overrides={"frame": {}})
    assert still.anchors.tobytes() == plain.anchors.tobytes()
    assert still.home.tobytes() == plain.home.tobytes()


@pytest.mark.parametrize("leaves", [{"type": "point"}, {"type": "pulley", "radius": 0.05, "axis": [1.0, 0.2, 0.3]}])
def test_a_moved_robot_moves_as_before_in_its_frame(leaves):
    """The same run turned about the vertical and shifted: tensions are those of before."""
    base = {"position": [2.0, -1.0, 0.5], "orientation": {"rpy": [0.0, 0.0, 0.7]}}
    turn = rotations.from_rpy(0.0, 0.0, 0.7)
    R, shift = rotations.matrix(turn), np.array(base["position"])
    short = {"simulation.duration": 0.3, "trajectory.duration": 0.3, "robot.cable.exit": leaves}
    end = rotations.from_rpy(0.0, 0.0, 0.3)
    moved = {
        **short,
        "robot.frame": base,
        "initial.position": (R @ [0.0, 0.0, 1.2] + shift).tolist(),
        "initial.orientation": {"quaternion": turn.tolist()},
        "trajectory.to": {
            "position": (R @ [0.2, 0.1, 1.3] + shift).tolist(),
            "orientation": {"quaternion": rotations.multiply(turn, end).tolist()},
        },
    }
    still = {**short, "trajectory.to": {"position": [0.2, 0.1, 1.3], "orientation": {"quaternion": end.tolist()}}}
    one, other = (cdpr.simulate(str(CAROCA), overrides=changes) for changes in (still, moved))
    assert np.abs(one.tension - other.tension).max() < TENSIONS
    assert np.abs(one.position @ R.T + shift - other.position).max() < TENSIONS


def test_checks_know_of_the_base():
    shifted = {"robot.frame": {"position": [0.0, 0.0, -3.0]}}
    anchor = {"robot.cables[0].frame": [0.6, -0.3, 4.0], "initial.position": [0.0, 0.0, 1.2]}
    load_scenario(str(CAROCA), overrides=anchor)
    with pytest.raises(cdpr.CdprError, match="cable 'cable_1' has no length here"):
        load_scenario(str(CAROCA), overrides={**anchor, **shifted})
    planar = str(ROOT / "scenarios" / "robots" / "planar.yaml")
    home = {"home": {"position": [0.0, 0.0, 1.0]}}
    load_robot(planar, overrides=home)
    with pytest.raises(cdpr.CdprError, match=r"home\.orientation: may differ from upright only about the free"):
        load_robot(planar, overrides={**home, "frame": {"orientation": {"rpy": [0.3, 0, 0]}}})


def test_the_frame_is_drawn_around_its_anchors_in_the_world():
    changes = {"frame": {"position": [0, 0, 1], "shape": "posts", "lower": [-4, -2, 0], "colour": "#102030"}}
    robot = load_robot(str(ROBOT), overrides=changes)
    edges = robot.frame.edges.reshape(-1, 2, 3)
    assert len(edges) == 4
    assert (edges[:, 0, :2] == edges[:, 1, :2]).all()
    assert {tuple(edge[0]) for edge in edges} == {(x, y, 1.0) for x in (-4, 3.5) for y in (-2, 2)}
    assert (edges[:, 1, 2] == 4.5).all()
    assert len(load_robot(str(ROBOT), overrides={"frame": {}}).frame.edges) == 12


@pytest.mark.parametrize(
    "shape",
    ["{box: [1, 1, 1]}", "{sphere: 0.4}", "{cylinder: {radius: 0.3, height: 0.6}}", "{mesh: tool.stl}"],
)
def test_the_sketch_shows_it(tmp_path, shape):
    (tmp_path / "tool.stl").write_bytes(binary(CORNERS))
    changes = [f"platform.shape={shape}", "platform.colour='#abcdef'", "frame={colour: '#123456', shape: posts}"]
    robot = load_robot(str(tmp_path / "r.yaml"), text=ROBOT.read_text(), overrides=changes)
    drawn = draw(pictures(Subject.of_robot(robot), np.zeros(1), robot.home[None, :3], robot.home[None, 3:]))
    text = drawn.markup("robot")
    assert "fill: #abcdef" in text
    assert "stroke: #123456" in text


@pytest.mark.parametrize(
    ("shape", "kind", "scale", "middle"),
    [
        ({"box": [1.0, 2.0, 3.0]}, 1, (1, 2, 3), (0, 0, 0)),
        ({"sphere": 0.5}, 2, (1, 1, 1), (0, 0, 0)),
        ({"cylinder": [0.5, 2.0]}, 3, (1, 1, 2), (0, 0, 0)),
        ({"mesh": [list(corner) for corner in AROUND]}, 1, (1, 1, 0.625), (0.5, -0.25, -0.1875)),
    ],
)
def test_viewers_show_it(tmp_path, shape, kind, scale, middle):
    frame = ((0.0, 0.0, 0.0, 0.0, 0.0, 4.0), (1.0, 0.0, 0.0, 1.0, 0.0, 4.0))
    header = make_header(shape=shape, frame=frame, colours={"platform": "#ff8000", "frame": "#000080"})
    rows = make_rows(header, 3)
    log = write_log(tmp_path / "log.mcap", header, rows)
    with log.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        *_, drawn = next(iter(reader.iter_decoded_messages(["/cdpr/markers"])))
    _, platform, posts = drawn.markers
    assert (platform.type, (platform.scale.x, platform.scale.y, platform.scale.z)) == (kind, scale)
    assert (platform.color.r, platform.color.g, platform.color.b) == pytest.approx((1, 128 / 255, 0))
    place = platform.pose.position
    if any(middle):
        assert (platform.header.frame_id, platform.frame_locked) == ("platform", True)
        assert (place.x, place.y, place.z) == middle
    else:
        assert platform.header.frame_id == "world"
        assert [place.x, place.y, place.z] == rows[0, header.layout.columns["position"]].tolist()
    assert posts.type == 5
    assert [(point.x, point.z) for point in posts.points] == [(0, 0), (0, 4), (1, 0), (1, 4)]
    assert posts.color.b == pytest.approx(128 / 255)


def test_headers_keep_it(tmp_path):
    changes = {"simulation.duration": 0.02, "robot.frame": {"colour": "red"}, "robot.platform.colour": "blue"}
    run = cdpr.simulate(str(CAROCA), overrides=changes, out=tmp_path / "run")
    header = cdpr.load_run(tmp_path / "run").header
    assert header == run.header
    assert len(header.frame) == 12
    assert header.colours == {"platform": "#0000ff", "frame": "#ff0000"}
    plain = make_header().to_dict()
    assert not {"frame", "colours"} & set(plain)
    assert Header.from_dict({**plain, "columns": []}).frame == ()


def test_looks_make_no_difference_to_a_run():
    short = {"simulation.duration": 0.05}
    looks = {"robot.frame": {"colour": "red"}, "robot.platform.shape": {"cylinder": {"radius": 1, "height": 1}}}
    one, other = (cdpr.simulate(str(CAROCA), overrides=changes) for changes in (short, {**short, **looks}))
    assert one.rows.tobytes() == other.rows.tobytes()


def test_nominal_values_may_be_in_another_file():
    scenario = load(BASE, "believed.frame.position=[0.01, 0, 0]")
    assert scenario.nominal.anchors[:, 0] == pytest.approx(scenario.robot.anchors[:, 0] + 0.01, abs=ROUND_OFF)
    assert scenario.nominal_differences == "frame.position [0.01, 0, 0] m instead of [0, 0, 0]"
    assert "believed.frame.colour" in load(BASE, "believed.frame.colour=red").unused
