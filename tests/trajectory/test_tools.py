"""Points of a platform that have a name: what they move, where they are exported to, where they come from."""

from __future__ import annotations

import json
from time import process_time
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from command_line import cdpr_here
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st

import cdpr
from cdpr import trajectory
from cdpr.base.errors import ScenarioError
from cdpr.formats import import_file
from cdpr.formats.write.export_model import begin, export
from cdpr.model import rotations
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide
from cdpr.simulation.exported import control_of
from cdpr.trajectory.tool import MISSED

NOZZLE = [0.1, 0.2, -0.5]
LIMITS = {"velocity": 1.0, "acceleration": 5.0, "jerk": 50.0}
CAROCA = yaml.safe_load((ROOT / "scenarios" / "robots" / "caroca.yaml").read_text())
# A quintic that meets both ends of a piece of duration h misses as u^3 (1 - u)^3 does, whose largest second derivative
# is 24 times its largest value, and the first 4 times; twice that, as it may miss more between the checked places.
BEND, SLOPE, TWICE = 24.0, 4.0, 2.0


def scenario(tmp_path, motion, robot=CAROCA, tools=None, **more):
    platform = {**robot["platform"], "tools": {"nozzle": NOZZLE} if tools is None else tools}
    content = {
        "robot": {**robot, "platform": platform},
        "trajectory": motion,
        "simulation": {"duration": 2.0, "control_step": 0.001},
        **more,
    }
    file = tmp_path / "tool.yaml"
    file.write_text(yaml.safe_dump(content))
    return cdpr.load_scenario(file)


def tip(sample, arm):
    """Position, velocity and acceleration of a point, by a sample (19,) of the platform's."""
    reach, spin = rotations.matrix(sample[3:7]) @ arm, sample[10:13]
    turned = np.cross(spin, reach)
    return (
        sample[:3] + reach,
        sample[7:10] + turned,
        sample[13:16] + np.cross(sample[16:], reach) + np.cross(spin, turned),
    )


def check(moved, wanted, arm, times):
    h = moved.segments[:, 1].min()
    allowed = np.array([1.0, SLOPE / h, BEND / h**2]) * TWICE * MISSED
    for time in times:
        got, want = moved.sample(time), wanted.sample(time)
        for values, expected, most in zip(tip(got, arm), (want[:3], want[7:10], want[13:16]), allowed, strict=True):
            assert np.abs(values - expected).max() <= most
        assert np.abs(got[3:7] - want[3:7]).max() < 1e-14
        assert np.abs(got[[10, 11, 12, 16, 17, 18]] - want[[10, 11, 12, 16, 17, 18]]).max() < 1e-10


points = st.tuples(*[st.floats(-2.0, 2.0)] * 3).map(np.array)
attitudes = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda angles: rotations.from_euler(np.array(angles), "XYZ"))


@given(st.lists(st.tuples(points, attitudes), min_size=2, max_size=4), points)
def test_the_tool_follows_the_motion(places, arm):
    knots = [trajectory.Knot(1.5 * k, *place) for k, place in enumerate(places)]
    wanted = trajectory.through(knots)
    moved = trajectory.of_tool(wanted, arm)
    assert (moved.start, moved.end) == (wanted.start, pytest.approx(wanted.end))
    check(moved, wanted, arm, np.linspace(-0.1, wanted.end + 0.1, 41))


@pytest.mark.slow
def test_hundreds_of_turns_are_soon_followed(tmp_path):
    """Each of the thousands of pieces by itself would take a minute."""
    motion = {"type": "circle", "tool": "nozzle", "duration": 2.0, "center": [0.0, 0.2, 0.7], "turning": True}
    made = scenario(tmp_path, {**motion, "turns": 400.0})
    begin = process_time()
    moved = made.planned
    assert len(moved.segments) > 20_000
    assert process_time() - begin < 10.0
    wanted = made.trajectory.make()
    check(moved, wanted, np.array(NOZZLE), np.linspace(0.0, 2.0, 101))


def test_a_platform_that_does_not_turn_is_an_offset_away():
    wanted = trajectory.circle(
        0.0,
        2.0,
        np.array([1.0, 0.0, 1.0]),
        rotations.from_euler(np.array([0.3, 0.2, 0.1]), "xyz"),
        np.array([0.0, 0.0, 1.0]),
        np.array([0.0, 0.0, 1.0]),
        1.0,
    )
    moved = trajectory.of_tool(wanted, np.array(NOZZLE))
    assert len(moved.segments) == len(wanted.segments)
    check(moved, wanted, np.array(NOZZLE), np.linspace(0.0, 2.0, 21))


def test_a_run_moves_its_tool(tmp_path):
    motion = {
        "type": "waypoints",
        "tool": "nozzle",
        "points": [
            {"time": 0, "position": [0.1, 0.2, 0.7]},
            {"time": 2, "position": [0.1, 0.2, 0.7], "orientation": {"rpy_deg": [10, -5, 20]}},
        ],
    }
    run = cdpr.simulate(scenario(tmp_path, motion))
    tips = run.tool("nozzle")
    assert run.status == "finished"
    assert np.abs(tips - [0.1, 0.2, 0.7]).max() < 1e-4  # it turns about its nozzle
    assert np.abs(run.position - run.position[0]).max() > 0.05
    assert run.header.tools == {"nozzle": tuple(NOZZLE)}
    with pytest.raises(cdpr.CdprError, match="tool: expected one of nozzle, got 'x'"):
        run.tool("x")


def test_a_target_is_the_origins_also_where_a_tool_moves(tmp_path):
    goal = {"type": "target", "time": 0.1, "position": [0.2, 0.1, 1.3], "duration": 0.5}
    turned = {"orientation": {"rpy_deg": [0, 0, 20]}}
    motion = {"type": "hold", "tool": "nozzle", "position": [0.1, 0.2, 0.7]}
    made = scenario(tmp_path, motion, events=[{**goal, **turned}]).desired
    assert np.abs(made.sample(1.0)[:3] - goal["position"]).max() < 1e-12


def test_a_log_keeps_tools_and_shows_their_frames(tmp_path):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    run = cdpr.simulate(scenario(tmp_path, {"type": "hold"}), out=str(tmp_path / "run"))
    again = cdpr.load_run(tmp_path / "run")
    assert np.array_equal(again.tool("nozzle"), run.tool("nozzle"))
    with (tmp_path / "run" / "log.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        message = next(decoded for *_, decoded in reader.iter_decoded_messages(topics=["/tf"]))
    frames = [(one.header.frame_id, one.child_frame_id) for one in message.transforms]
    assert frames == [("world", "platform"), ("platform", "nozzle")]
    at = message.transforms[1].transform
    assert [at.translation.x, at.translation.y, at.translation.z, at.rotation.w] == [*NOZZLE, 1.0]
    assert message.transforms[1].header.stamp.nanosec == message.transforms[0].header.stamp.nanosec


def test_a_tool_begins_as_fast_as_the_platform_carries_it():
    turned = {"quaternion": tuple(rotations.from_rpy(0.1, -0.2, 0.3).tolist())}
    keys = {"position": (1.0, 2.0, 3.0), "velocity": (0.1, 0.2, 0.3), "angular_velocity": (0.4, -0.5, 0.6)}
    initial = Initial(**keys, orientation=turned)
    state = initial.state()
    sample = np.concatenate([state, np.zeros(6)])
    at, speed, _ = tip(sample, np.array(NOZZLE))
    begins = initial.of_tool(np.array(NOZZLE))
    assert begins.position == pytest.approx(at)
    assert begins.velocity == pytest.approx(speed)
    assert begins.angular_velocity == keys["angular_velocity"]


def test_motions_begin_where_the_tool_is(tmp_path):
    motion = {"type": "circle", "tool": "nozzle", "duration": 2.0, "center": [0.0, 0.2, 0.7]}
    made = scenario(tmp_path, motion)
    assert made.trajectory.position == pytest.approx((0.1, 0.2, 0.7))  # home is at 0, 0, 1.2
    assert made.planned.sample(0.0)[:3] == pytest.approx([0.0, 0.0, 1.2])
    assert made.planned.sample(1.0)[:3] == pytest.approx([-0.2, 0.0, 1.2])


def test_gcode_moves_a_nozzle(tmp_path):
    (tmp_path / "square.ngc").write_text("G90 G21\nG1 X100 Y200 Z700 F60000\nG1 X200\nM2\n")
    motion = {"type": "gcode", "tool": "nozzle", "file": "square.ngc", "limits": LIMITS}
    made = scenario(tmp_path, motion)
    assert made.planned.sample(made.planned.end)[:3] == pytest.approx([0.1, 0.0, 1.2])


def test_a_study_may_move_the_tool(tmp_path):
    made = scenario(tmp_path, {"type": "hold", "tool": "nozzle", "position": [0.1, 0.2, 0.7]})
    changes = {"robot.platform.tools.nozzle": [0.0, 0.0, -0.5]}
    assert made.planned.sample(0.0)[:3] == pytest.approx([0.0, 0.0, 1.2])  # kept from now on
    other = cdpr.load_scenario(tmp_path / "tool.yaml", overrides=changes, before=made)
    assert other.planned.sample(0.0)[:3] == pytest.approx([0.1, 0.2, 1.2])


def test_unreachable_poses_are_reported(tmp_path):
    """A tool that hangs far below may be where the platform could not, and the other way round."""
    tools = {"weight": [0.0, 0.0, -20.0]}
    below = {"type": "hold", "tool": "weight", "position": [0.0, 0.0, -18.8]}
    assert scenario(tmp_path, below, tools=tools).warnings == ()
    told = scenario(tmp_path, {**below, "position": [0.0, 0.0, 1.2]}, tools=tools).warnings
    assert any(one.path == ("trajectory", "position") for one in told)


def test_an_exported_controller_begins_where_the_tool_wants_the_platform(tmp_path):
    turned = {"rpy_deg": [10, -5, 20]}
    motion = {"type": "hold", "tool": "nozzle", "position": [0.1, 0.2, 0.7], "orientation": turned}
    made = scenario(tmp_path, motion, solver={"type": "closed_form"})
    starts = [variable.values for variable in control_of(made).inputs()]
    assert np.concatenate(starts) == pytest.approx(made.planned.sample(0.0))
    assert tip(np.concatenate(starts), np.array(NOZZLE))[0] == pytest.approx([0.1, 0.2, 0.7])


WRONG = {
    "unknown": ({"type": "hold", "tool": "x"}, {}, "trajectory.tool: the platform has no tool 'x': allowed are nozzle"),
    "none": (
        {"type": "hold", "tool": "x"},
        {"tools": {}},
        "has no tool 'x': the robot has none; define them in robot.platform.tools",
    ),
    "two numbers": ({"type": "hold"}, {"tools": {"a": [1.0, 2.0]}}, "tools.a: expected 3 numbers (m), got 2"),
    "no list": ({"type": "hold"}, {"tools": {"a": 1.0}}, "tools.a: expected 3 numbers (m), got 1"),
    "a text": ({"type": "hold"}, {"tools": {"a": [1.0, "x", 2.0]}}, "tools.a[1]: expected a number (m), got 'x'"),
    "a taken name": ({"type": "hold"}, {"tools": {"platform": NOZZLE}}, "have this name already; choose another name"),
    "a cable's end": ({"type": "hold"}, {"tools": {"cable_1_frame": NOZZLE}}, "have this name already"),
    "no name": ({"type": "hold"}, {"tools": {"a b": NOZZLE}}, "write a_b"),
    "far": ({"type": "hold"}, {"tools": {"a": [1e9, 0.0, 0.0]}}, "must lie between"),
}


@pytest.mark.parametrize("name", WRONG)
def test_errors_are_reported(tmp_path, name):
    motion, more, text = WRONG[name]
    with pytest.raises(ScenarioError, match=r"tool\.yaml:\d+:\d+") as caught:
        scenario(tmp_path, motion, **more)
    assert text in str(caught.value)


@pytest.mark.parametrize(
    "wrong",
    [
        {"simulation": {"control_step": 0.001}},
        {"robot": {**CAROCA, "platform": {**CAROCA["platform"], "mass": -1.0, "tools": {"nozzle": NOZZLE}}}},
    ],
)
def test_other_errors_do_not_hide_an_invalid_tool(tmp_path, wrong):
    with pytest.raises(ScenarioError, match=r"trajectory\.tool: the platform has no tool 'nozle'") as caught:
        scenario(tmp_path, {"type": "hold", "tool": "nozle"}, **wrong)
    assert len(caught.value.rows) == 2


@pytest.mark.parametrize("robot", ["nothing.yaml", {**CAROCA, "platform": None}])
def test_tools_of_a_platform_that_is_not_known_are_not_missed(tmp_path, robot):
    file = tmp_path / "tool.yaml"
    file.write_text(yaml.safe_dump({"robot": robot, "trajectory": {"type": "hold", "tool": "nozzle"}}))
    with pytest.raises(ScenarioError) as caught:
        cdpr.load_scenario(file)
    assert "has no tool" not in str(caught.value)


PLANAR = yaml.safe_load((ROOT / "scenarios" / "robots" / "planar.yaml").read_text())
SPHERICAL = yaml.safe_load((ROOT / "scenarios" / "robots" / "spherical.yaml").read_text())


def test_guides_let_tools_move_as_far_as_they_can(tmp_path):
    assert PLANAR["dof"] == ["x", "z", "ry"]
    at = PLANAR["home"]["position"]
    there = [at[0] + 0.1, at[1] + 0.2, at[2] - 0.3]
    motion = {"type": "hold", "tool": "nozzle", "position": there}
    made = scenario(tmp_path, motion, PLANAR, {"nozzle": [0.0, 0.2, -0.2]})
    assert made.planned.sample(0.0)[:3] == pytest.approx([at[0] + 0.1, at[1], at[2] - 0.1])
    with pytest.raises(ScenarioError, match="the initial position holds tool 'nozzle' at y = "):
        scenario(tmp_path, {**motion, "position": at}, PLANAR, {"nozzle": [0.0, 0.2, -0.2]})
    with pytest.raises(ScenarioError, match="this tool would leave the guide"):
        scenario(tmp_path, {"type": "hold", "tool": "nozzle"}, SPHERICAL)


def test_a_guide_with_one_slide_holds_what_a_turn_would_lift():
    beside, below, along = np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.0, -0.2]), np.array([0.0, 0.4, 0.0])
    kept = {
        ("x", "ry"): [False, False, True],  # z is held, and a point below rises as soon as it has left the vertical
        ("x", "z", "ry"): [True, True, True],
        ("x", "y", "rz"): [True, True, True],
        ("x", "y", "z"): [True, True, True],
        ("x",): [True, True, True],
        ("rx", "ry", "rz"): [False, False, False],
        ("y", "ry"): [False, False, True],
    }
    for dof, wanted in kept.items():
        guide = Guide(dof, (0.0, 0.0, 1.0), lambda path, text: None)
        assert [guide.keeps(arm) for arm in (beside, below, along)] == wanted, dof


@pytest.fixture
def robot(tmp_path):
    file = tmp_path / "nozzled.yaml"
    turned = {"center_of_mass": [0.05, 0.0, -0.02], "inertia": [6.5, 20.0, 22.5, 2.0, -1.5, 1.0]}  # off the axes
    platform = {**CAROCA["platform"], **turned, "tools": {"nozzle": NOZZLE}}
    file.write_text(yaml.safe_dump({**CAROCA, "platform": platform}))
    return file


def test_it_is_a_site_that_comes_back(tmp_path, robot):
    mujoco = pytest.importorskip("mujoco")
    text = export(begin(cdpr.load_robot(robot)), "mjcf")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)
    assert data.site("nozzle").xpos == pytest.approx(np.add([0.0, 0.0, 1.2], NOZZLE), abs=1e-12)
    assert data.site("nozzle").xmat == pytest.approx(np.eye(3).ravel(), abs=1e-12)
    (tmp_path / "back.xml").write_text(text)
    (back,) = map(yaml.safe_load, import_file(tmp_path / "back.xml").files.values())
    assert back["platform"]["tools"] == {"nozzle": NOZZLE}


@pytest.mark.parametrize(("style", "version"), [("platform", "1.9"), ("platform", "1.6"), ("legs", "1.9")])
def test_it_is_a_frame_or_a_ball_of_sdf(robot, style, version):
    from cdpr.formats.write.export_model import Options

    root = ElementTree.fromstring(export(begin(cdpr.load_robot(robot)), "sdf", Options(style, version)))
    kind = "frame" if version == "1.9" else "visual"
    (found,) = (each for each in root.iter(kind) if each.get("name") == "nozzle")
    assert [float(word) for word in found.find("pose").text.split()[:3]] == NOZZLE


def test_it_is_a_link_of_urdf(robot):
    root = ElementTree.fromstring(export(begin(cdpr.load_robot(robot)), "urdf"))
    (joint,) = (each for each in root.iter("joint") if each.get("name") == "nozzle")
    assert joint.find("parent").get("link") == "platform"
    assert [float(word) for word in joint.find("origin").get("xyz").split()] == NOZZLE
    assert any(each.get("name") == "nozzle" for each in root.iter("link"))


def test_info_reports_it(robot):
    assert "nozzle at [0.1, 0.2, -0.5] m" in cdpr_here("info", str(robot)).stdout
    told = json.loads(cdpr_here("info", str(robot), "--json").stdout)
    assert told["robot"]["platform"]["tools_m"] == {"nozzle": NOZZLE}
