"""Robots of the thesis's Gazebo plug-in and of its successor, and WireX's: what their numbers become."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from plugin_cases import POINTS, SUCCESSOR, THESIS, TRAJECTORY, wirex

import cdpr
from cdpr.base.errors import CdprError, OutputError
from cdpr.formats import import_file
from cdpr.formats.read.import_files import ImportResult, write
from cdpr.formats.read.imported import unique
from cdpr.mechanics.kinematics import lengths, make_state

CAROCA = ROOT / "scenarios" / "robots" / "caroca.yaml"
SAME = 1e-12  # m


def here(*words):
    return cdpr_here(*words, code=None)


def robot_of(folder, text, name="robot.yaml"):
    (folder / name).write_text(text)
    taken = import_file(folder / name)
    return cdpr.load_robot(write(taken, folder / "out", force=True)[0]), taken


def test_the_successors_numbers(tmp_path):
    robot, taken = robot_of(tmp_path, SUCCESSOR)
    assert robot.platform.mass == 15.0
    I = robot.platform.inertia  # noqa: E741
    assert (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]) == (0.5, 0.6, 0.7, 0.01, 0.02, 0.03)
    assert robot.tension_min.tolist() == [5.0] * 4
    assert robot.tension_max.tolist() == [900.0] * 4
    assert robot.home[:3].tolist() == [0.1, 0.2, 0.3]
    assert robot.home[3:].tolist() == pytest.approx(cdpr.model.rotations.from_rpy(0.1, 0.2, 0.3).tolist())
    assert robot.anchors.tolist()[1] == [2.0, 1.0, 3.0, -0.2, 0.15, -0.125]
    assert robot.cables[0].diameter == 0.01
    assert len(robot.frame.edges) == 4  # posts
    for said in ("sim_cables", "cable.mass", "joints.passive", "joints.actuated.velocity", "'Turquoise' is unknown"):
        assert [text for text in taken.left_out if said in text], said
    assert "# kg, platform.mass, line 7" in taken.files["robot.yaml"]


def test_the_thesiss_inertia_is_that_of_its_generator(tmp_path):
    robot, taken = robot_of(tmp_path, THESIS)
    a, b, c = 0.4, 0.3, 0.25
    wanted = [50 / 12 * (b * b + c * c), 50 / 12 * (a * a + c * c), 50 / 12 * (a * a + b * b)]
    assert np.allclose(np.diag(robot.platform.inertia), wanted)
    assert robot.platform.shape.size == pytest.approx((a, b, c))
    assert [text for text in taken.left_out if "inertial: its generator ignores it" in text]
    assert [text for text in taken.left_out if "global_frame" in text]
    bare = THESIS.replace("lower: [-0.2, -0.15, -0.125], upper: [0.2, 0.15, 0.125],", "").replace("9", "0")
    _, taken = robot_of(tmp_path, bare, "bare.yaml")
    assert "inertia: ixx, iyy, izz was 0, filled with" in taken.warnings[0]


OLDER = "time: {t0: 0.0, t4: 3.0}\nposition: {A: [0, 0, 1], C: [0.5, 0.2, 1.2]}\n"
INITIAL = "time: {initial: 0.0, finial: 3.0}\nposition: {initial: [0, 0, 1], finial: [0.5, 0.2, 1.2]}\n"
S_CURVE = "time: {t0: 0.0, t4: 3.0}\nposition: {A: [0, 0, 1], B: [0.5, 0.2, 1.2]}\n"


def test_the_straight_line_of_an_older_revision_ends_in_c_at_t4(tmp_path):
    (tmp_path / "robot.yaml").write_text(SUCCESSOR)
    (tmp_path / "way.yaml").write_text(OLDER)
    taken = import_file(tmp_path / "robot.yaml", trajectory=str(tmp_path / "way.yaml"))
    write(taken, tmp_path / "out", force=False)
    assert cdpr.load_scenario(tmp_path / "out" / "robot_way.yaml").simulation.duration == 3.0
    assert [text for text in taken.warnings if "a quintic move from A at t0 to C at t4" in text]
    assert [text for text in taken.warnings if "keeps its home orientation" in text]


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        (INITIAL, "time.initial, time.finial, position.initial, position.finial"),
        (S_CURVE, "time.t0, time.t4, position.A, position.B"),
        ("waypoints:\n- {t: 0, p: [0, 0, 1]}\n", "waypoints"),
        ("[1, 2]\n", ""),
    ],
)
def test_trajectories_of_other_revisions_are_refused_with_their_own_keys(tmp_path, text, keys):
    (tmp_path / "robot.yaml").write_text(SUCCESSOR)
    (tmp_path / "way.yaml").write_text(text)
    with pytest.raises(CdprError, match=r"way\.yaml:1") as caught:
        import_file(tmp_path / "robot.yaml", trajectory=str(tmp_path / "way.yaml"))
    assert f"this file has {keys}. " in str(caught.value) or not keys


def test_oker_morgants_caroca_is_ours(tmp_path):
    """Their file equals ours in other terms: cables have the same lengths at any pose of the platform."""
    ours = cdpr.load_robot(CAROCA)
    points = "".join(
        f"- frame: {cable.frame.tolist()}\n  platform: {cable.platform.tolist()}\n" for cable in ours.cables
    )
    text = SUCCESSOR.replace(POINTS, f"points:\n{points}").replace("sim_cables: true", "sim_cables: false")
    theirs, _ = robot_of(tmp_path, text)
    rng = np.random.default_rng(1)
    for _ in range(100):
        q = rng.normal(size=4)
        state = make_state(rng.uniform(-1.0, 2.0, 3), q / np.linalg.norm(q))
        assert np.allclose(lengths(ours, state), lengths(theirs, state), atol=SAME)


def test_a_trajectory_belongs_to_a_robot(tmp_path):
    (tmp_path / "robot.yaml").write_text(SUCCESSOR)
    (tmp_path / "way.yaml").write_text(TRAJECTORY)
    done = here("import", tmp_path / "robot.yaml", "--trajectory", tmp_path / "way.yaml", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "a quintic move from A at t0 to B at t1" in done.stderr
    scenario = cdpr.load_scenario(tmp_path / "out" / "robot_way.yaml")
    assert scenario.simulation.duration == 4.0
    assert scenario.desired.sample(0.0)[:3].tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert scenario.desired.sample(4.0)[:3].tolist() == pytest.approx([0.5, 0.2, 1.0])
    assert "kp: 20.0\n  kd: 10.0\n" in (tmp_path / "out" / "robot_way.yaml").read_text()
    done = here("import", tmp_path / "way.yaml")
    assert done.returncode == 2
    assert "way.yaml:1: this is a trajectory: import its robot, and name this as its trajectory" in done.stderr


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("mass: 15", "mass: -15"), "the robot is invalid: platform.mass: must be greater than 0"),
        (
            ("mass: 15", "mass: heavy"),
            "robot.yaml:7: platform.mass: expected a number of at most 1e+12, got 'heavy'",
        ),
        (("mass: 15,", ""), "platform.mass: expected a number of at most 1e+12, got null"),
        (("[-2.0, 1.0, 3.0]", "[-2.0, 1.0]"), "points[0].frame: expected 3 numbers, got a list"),
        (("[0.5, 0.6, 0.7,", "[0.5, 0.6, 7.0,"), "platform.inertia: no rigid body has this inertia"),
        (("points:", "points: &a"), ""),
        (("type: poles", "type: [poles]"), ""),
        (("joints:", "jints:"), "joints.actuated.min: expected a number of at most 1e+12, got null"),
        (("sim_cables: true", "sim_cables: [true"), "robot.yaml:14:13: not valid YAML"),
    ],
)
def test_errors_are_reported_with_their_line(tmp_path, change, said):
    (tmp_path / "robot.yaml").write_text(SUCCESSOR.replace(*change))
    if not said:  # an unused anchor is no error
        import_file(tmp_path / "robot.yaml")
        return
    with pytest.raises(CdprError) as caught:
        import_file(tmp_path / "robot.yaml")
    assert said in str(caught.value)
    assert str(tmp_path / "robot.yaml") in str(caught.value)


def test_a_body_without_inertia_is_a_ball(tmp_path):
    """As the first files of the successor have it."""
    bare = SUCCESSOR.replace("inertia: [0.5, 0.6, 0.7, 0.01, 0.02, 0.03], size: [0.4, 0.3, 0.25],", "")
    robot, taken = robot_of(tmp_path, bare)
    radius = np.linalg.norm([0.2, 0.15, 0.125])
    assert np.allclose(robot.platform.inertia, 0.4 * 15.0 * radius**2 * np.eye(3))
    assert [text for text in taken.warnings if "robot.yaml:6: inertia: ixx, iyy, izz was 0, filled" in text]


def test_a_trajectory_alone_is_reported(tmp_path):
    (tmp_path / "way.yaml").write_text(TRAJECTORY)
    with pytest.raises(CdprError, match=r"way.yaml:1: this is a trajectory: import its robot, and name this"):
        import_file(tmp_path / "way.yaml")


def test_a_missing_winch_is_reported(tmp_path):
    """Otherwise its cables would pull up to their breaking load, without a message."""
    robot, taken = robot_of(tmp_path, wirex(**{'winch name="W"': 'winch name="V"'}), "crane.wcrfx")
    assert robot.tension_max.tolist() == [9000.0] * 4
    said = "crane.wcrfx:2: the largest tension is what the cable breaks at, 9000 N: winchtype 'W' is not a winch"
    assert len([text for text in taken.warnings if said in text]) == 1
    assert not [text for text in taken.left_out if "breaking_load" in text]
    _, known = robot_of(tmp_path, wirex(), "known.wcrfx")
    assert not [text for text in known.warnings if "breaks at" in text]
    assert [text for text in known.left_out if "breaking_load" in text]


@pytest.mark.parametrize(
    ("use", "cable", "limits"),
    [
        ('<application max_cable_load="500" min_cable_load="3"/>', 'minimum_load="7"', (3.0, 500.0)),
        ('<application max_cable_load="500"/>', 'minimum_load="7"', (7.0, 500.0)),
        ("", 'minimum_load="7"', (7.0, 700.0)),
        ("", "", (0.0, 700.0)),
    ],
)
def test_limits_of_wirex_are_those_of_the_application_first(tmp_path, use, cable, limits):
    text = wirex(**{"</robot>": f"{use}</robot>", '<cable name="c"': f'<cable name="c" {cable}'})
    robot, _ = robot_of(tmp_path, text, "crane.wcrfx")
    assert set(zip(robot.tension_min.tolist(), robot.tension_max.tolist(), strict=True)) == {limits}


@pytest.mark.parametrize(("pattern", "dof"), [("1R2T", ("x", "z", "ry")), ("2T", ("x", "z"))])
def test_planar_robots_of_wirex_move_in_the_plane_of_their_bases(tmp_path, pattern, dof):
    flat = wirex(**{"3R3T": pattern})
    for y in (-1, 1):
        flat = flat.replace(f'y="{y}" z="3"', f'y="0" z="{2 + y}"').replace(
            f'x="0.1" y="{y}" z="0"', 'x="0.1" y="0" z="0"'
        )
    robot, _ = robot_of(tmp_path, flat, "crane.wcrfx")
    assert robot.dof == dof


def test_a_wirex_body_without_inertia_is_a_ball_about_its_centre_of_mass(tmp_path):
    bare = wirex(**{'<inertiatensor Ixx="3" Iyy="4" Izz="5" Ixy="0.1"/>': ""})
    robot, _ = robot_of(tmp_path, bare, "crane.wcrfx")
    square = np.mean([np.sum(np.subtract(row[3:], [0.1, 0.0, -0.2]) ** 2) for row in robot.anchors])
    assert np.allclose(robot.platform.inertia, 0.4 * 20.0 * square * np.eye(3))


def test_chains_of_wirex(tmp_path):
    robot, taken = robot_of(tmp_path, wirex(0.05), "crane.wcrfx")
    assert robot.name == "Crane_1"
    assert robot.anchors.tolist()[2] == [2.0, 1.0, 3.0, 0.1, 1.0, 0.0]
    assert robot.platform.center_of_mass.tolist() == [0.1, 0.0, -0.2]
    I = robot.platform.inertia  # noqa: E741
    assert (I[0, 0], I[1, 1], I[2, 2], I[0, 1]) == (3.0, 4.0, 5.0, 0.1)
    assert robot.cables[0].axial_stiffness == pytest.approx(1.1e9 * math.pi * 0.003**2)
    assert robot.cables[0].linear_density == 0.02
    assert robot.cables[0].speed_max == 2.0
    assert robot.tension_max.tolist() == [700.0] * 4
    assert robot.cables[0].exit.radius == 0.05
    assert robot.cables[0].exit.axis == pytest.approx((0.0, -1.0, 0.0))  # the third column of a11 to a33
    assert [text for text in taken.warnings if "pulleys of 0.05 m" in text]
    plain, _ = robot_of(tmp_path, wirex(), "plain.wcrfx")
    assert plain.cables[0].exit is None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({'a33="0"': 'a33="2"'}, "a11 to a33 do not form a rotation matrix"),
        ({'a11="1"': 'a11="-1"'}, "a11 to a33 do not form a rotation matrix"),  # but a mirror
        (
            {'motionpattern="3R3T"': 'motionpattern="2R3T"'},
            "motionpattern: expected one of 3R3T, 3T, 1R2T, 2T, got '2R3T'",
        ),
        ({'x="-2"': 'x="left"'}, "crane.wcrfx:2: x of <base>: expected a number, of at most 1e+12, got 'left'"),
        ({'f_max="700"': 'f_max="0"', 'breaking_load="9000"': ""}, "expected a largest tension above 0 N"),
        ({"</models>": ""}, "invalid XML"),
        ({"<robot ": "<robot/><robot "}, "expected one <robot>, got 2"),
    ],
)
def test_errors_in_wirex_files_are_reported(tmp_path, change, said):
    with pytest.raises(CdprError, match=r"crane.wcrfx:\d+: ") as caught:
        robot_of(tmp_path, wirex(0.05, **change), "crane.wcrfx")
    assert said in str(caught.value)


def test_nothing_is_written_over(tmp_path):
    (tmp_path / "robot.yaml").write_text(SUCCESSOR)
    first = here("import", tmp_path / "robot.yaml", "--out", tmp_path / "out", "--json")
    assert json.loads(first.stdout)[0]["files"] == [str(tmp_path / "out" / "robot.yaml")]
    before = (tmp_path / "out" / "robot.yaml").read_bytes()
    again = here("import", tmp_path / "robot.yaml", "--out", tmp_path / "out")
    assert again.returncode == 8
    assert "already exists and is not overwritten" in again.stderr
    assert here("import", tmp_path / "robot.yaml", "--out", tmp_path / "out", "--force").returncode == 0
    assert (tmp_path / "out" / "robot.yaml").read_bytes() == before


def test_nothing_is_written_through_a_link_and_no_half_stays(tmp_path, monkeypatch):
    (tmp_path / "robot.yaml").write_text(SUCCESSOR)
    (tmp_path / "way.yaml").write_text(TRAJECTORY)
    taken = import_file(tmp_path / "robot.yaml", trajectory=str(tmp_path / "way.yaml"))
    out = tmp_path / "out"
    out.mkdir()
    (out / "robot_way.yaml").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(CdprError, match=r"robot_way\.yaml' already exists and is not overwritten: choose another"):
        write(taken, out, force=False)
    assert not (tmp_path / "elsewhere").exists()
    (out / "robot_way.yaml").unlink()
    whole = Path.write_bytes

    def full(path, content):
        whole(path, content[:10])
        if "robot_way.yaml" in path.name:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(CdprError, match="No space left on device"):
        write(taken, out, force=False)
    assert list(out.iterdir()) == []


def test_many_cables_of_one_name_take_no_time():
    names = unique(["c", "c_2", "d"] + ["c"] * 30_000)  # each was compared with all others
    assert names[:5] == ["c", "c_2", "d", "c_3", "c_4"]
    assert len(set(names)) == len(names)


def test_two_robots_of_one_name_do_not_overwrite_each_other(tmp_path):
    for folder, mass in (("a", 15), ("b", 16), ("c", 17)):
        (tmp_path / "in" / folder).mkdir(parents=True)
        (tmp_path / "in" / folder / "robot.yaml").write_text(SUCCESSOR.replace("mass: 15", f"mass: {mass}"))
    done = here("import", tmp_path / "in", "--out", tmp_path / "out")
    assert done.returncode == 0
    assert "3 of 3 could be read" in done.stdout
    robots = [cdpr.load_robot(tmp_path / "out" / f"{name}.yaml") for name in ("robot", "robot_2", "robot_3")]
    assert [(robot.name, robot.platform.mass) for robot in robots] == [("robot", 15), ("robot_2", 16), ("robot_3", 17)]


@pytest.mark.parametrize("content", [b"", b"\x00\xff\xfe", b"<a", b"points: [actuated", b"%PDF-1.4 points: actuated"])
def test_files_of_nothing_end_in_one_line(tmp_path, content):
    (tmp_path / "x.yaml").write_bytes(content)
    done = here("import", tmp_path / "x.yaml")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert str(tmp_path / "x.yaml") in done.stderr


def test_a_failed_import_removes_no_file_of_another_process(tmp_path, monkeypatch):
    found = ImportResult("robot.xml", {"robot.yaml": "mine", "scenario.yaml": "mine"})
    (tmp_path / "scenario.yaml").write_text("another's")
    monkeypatch.setattr("os.path.lexists", lambda path: False)  # created after the check
    with pytest.raises(OutputError, match="cannot be written: File exists"):
        write(found, tmp_path, force=False)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"scenario.yaml": "another's"}
