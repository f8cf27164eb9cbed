"""SDF with cables as legs, as the generators of the Gazebo plug-in write it: what it becomes, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from conftest import ROOT
from scipy.spatial.transform import Rotation
from sdf_cases import ANCHORS, FRAMES, HOME, Dialect, R, joint, link, six, text

import cdpr
from cdpr.base.errors import FormatError
from cdpr.formats import import_file
from cdpr.ui.cli import cli


def robot_of(tmp_path, content):
    """Import a text, and return the robot and the messages."""
    (tmp_path / "hall.sdf").write_text(content)
    taken = import_file(tmp_path / "hall.sdf")
    (tmp_path / "robot.yaml").write_text(next(iter(taken.files.values())))
    return cdpr.load_robot(tmp_path / "robot.yaml"), taken


MICRO = 1e-6  # the generators write six decimals, of places and of angles

THESIS = Dialect("linear{i}", swapped=True, effort=6500, velocity=100, name="/home/someone/cdpr3/sdf/hall")


@pytest.mark.parametrize("dialect", [Dialect(), THESIS], ids=["oKermorgant", "thesis"])
def test_both_generators(tmp_path, dialect):
    robot, taken = robot_of(tmp_path, text(dialect))
    np.testing.assert_allclose([cable.frame for cable in robot.cables], FRAMES, atol=2 * MICRO)
    np.testing.assert_allclose([cable.platform for cable in robot.cables], ANCHORS, atol=5 * MICRO)
    assert [cable.name for cable in robot.cables] == [dialect.slide.format(i=i) for i in range(8)]
    assert {cable.tension_max for cable in robot.cables} == {dialect.effort}
    assert robot.platform.mass == 150
    np.testing.assert_allclose(robot.platform.inertia, np.diag([6.5, 20, 22.5]))
    np.testing.assert_allclose(robot.home[:3], HOME, atol=MICRO)
    np.testing.assert_allclose(Rotation.from_quat(robot.home[[4, 5, 6, 3]]).as_matrix(), R, atol=MICRO)
    assert robot.name == "hall"
    assert {cable.diameter for cable in robot.cables} == {0.01}
    assert yaml.safe_load(taken.files["hall.yaml"])["platform"]["shape"] == {"box": [1.2, 0.6, 0.4]}
    assert any("the smallest tension is 0 N" in told for told in taken.warnings)
    assert any("plugin 'libcdpr_plugin.so'" in told for told in taken.left_out)


def test_a_model_at_another_position(tmp_path):
    moved, _ = robot_of(tmp_path, text(Dialect(pose="1 2 3 0 0 1.5")))
    turned = Rotation.from_euler("z", 1.5).as_matrix()
    np.testing.assert_allclose([c.frame for c in moved.cables], FRAMES @ turned.T + [1, 2, 3], atol=2 * MICRO)
    np.testing.assert_allclose([c.platform for c in moved.cables], ANCHORS, atol=5 * MICRO)


def test_the_pose_of_the_inertia_is_used(tmp_path):
    wanted = "<inertial><pose>0.1 0.2 0.3 0 0 1.5707963267948966</pose>"
    content = (
        text()
        .replace("<inertial>", "<INERTIAL>", 1)
        .replace("<inertial>", wanted, 1)
        .replace("<INERTIAL>", "<inertial>")
    )
    robot, _ = robot_of(tmp_path, content)
    np.testing.assert_allclose(robot.platform.center_of_mass, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(robot.platform.inertia, np.diag([20, 6.5, 22.5]), atol=1e-12)
    robot, _ = robot_of(tmp_path, content.replace("0 0 1.5707963267948966", "0.3 -0.4 0.5"))
    turned = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    np.testing.assert_allclose(robot.platform.inertia, turned @ np.diag([6.5, 20, 22.5]) @ turned.T, atol=1e-12)


def test_legs_with_universal_and_ball_joints(tmp_path):
    """Two links and three joints a leg, the last with its place in the platform's axes."""
    legs = []
    for i, (begin, anchor) in enumerate(zip(FRAMES, ANCHORS, strict=True)):
        legs += [
            link(f"lower{i}", six(begin, (0, 0, 0))),
            link(f"upper{i}", six(HOME, (0, 0, 0))),
            joint(f"u{i}", "universal", "frame", f"lower{i}", "0 0 0 0 0 0", "1 0 0"),
            joint(f"c{i}_slide", "prismatic", f"lower{i}", f"upper{i}", "0 0 0 0 0 0", "0 0 1", "<effort>5</effort>"),
            joint(f"b{i}", "ball", f"upper{i}", "platform", six(anchor, (0, 0, 0)), "1 0 0"),
        ]
    content = text(legs=0).replace("    <plugin", "".join(legs) + "    <plugin")
    robot, _ = robot_of(
        tmp_path, content.replace("<model", "<world name='w'><model", 1).replace("</model>", "</model></world>")
    )
    np.testing.assert_allclose([cable.frame for cable in robot.cables], FRAMES, atol=MICRO)
    np.testing.assert_allclose([cable.platform for cable in robot.cables], ANCHORS, atol=MICRO)
    assert [cable.name for cable in robot.cables][:2] == ["c0", "c1"]


def test_the_first_generator_wrote_the_velocity_as_the_effort(tmp_path):
    _, taken = robot_of(tmp_path, text(Dialect(effort=10, velocity=10)))
    assert any("effort and velocity of slides are the same" in told for told in taken.warnings)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ('name="platform"', 'name="body"', "expected one <model> with a <link> named 'platform', got 0"),
        (
            "<parent>platform</parent>",
            "<parent>frame</parent>",
            "is not a leg: it does not lead from 'frame' to 'platform'",
        ),
        ("<parent>platform</parent>", "<parent>nothing</parent>", "joins the link 'nothing', which does not exist"),
        ('type="prismatic"', 'type="screw"', "no joint is prismatic"),
        ("<effort>900.0</effort>", "", "expected <effort>, the largest tension in N"),
        ("<effort>900.0</effort>", "<effort>-1</effort>", "expected <effort>, the largest tension in N"),
        ("<effort>900.0</effort>", "<effort>nan</effort>", "expected a number"),
        ('<link name="virt_X1">', '<link name="virt_X0">', "link 'virt_X0' occurs twice"),
        (
            "<pose>0 0 0 0 0 0</pose>",
            "<pose relative_to='x'>0 0 0 0 0 0</pose>",
            "expected a <pose> without attributes",
        ),
        ("<pose>0 0 0 0 0 0</pose>", "<pose>0 0 0</pose>", "expected 6 numbers"),
        ("<mass>150</mass>", "", "expected one <mass> within <inertial>, got 0"),
        (
            "<effort>900.0</effort>",
            "<effort>1e16</effort>",
            "got '1e16': of slide 'cable0' it is the largest tension, N",
        ),
        ("<mass>150</mass>", "<mass>-150</mass>", "the robot is invalid"),
        ("</sdf>", "", "invalid XML"),
        ("<parent>frame</parent>", "<parent>virt_Y0</parent>", "is not a leg"),
    ],
)
def test_rejections_are_one_line_with_the_position(tmp_path, old, new, what):
    content = text()
    assert old in content
    (tmp_path / "hall.sdf").write_text(content.replace(old, new))
    with pytest.raises(FormatError) as caught:
        import_file(tmp_path / "hall.sdf")
    (line,) = str(caught.value).splitlines()
    assert what in line
    assert line.startswith(f"{tmp_path / 'hall.sdf'}:")


def test_from_the_command_line(tmp_path):
    (tmp_path / "hall.sdf").write_text(text())
    done = CliRunner().invoke(cli, ["import", str(tmp_path / "hall.sdf"), "--out", str(tmp_path / "mine")])
    assert done.exit_code == 0, done.output
    assert cdpr.load_robot(tmp_path / "mine" / "hall.yaml").m == 8
    done = CliRunner().invoke(cli, ["import", str(tmp_path), "--out", str(tmp_path / "all")])
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize("version", ["1.6", "1.9"])
def test_round_trip_of_legs(tmp_path, version):
    """At a pose that is turned, so that anchors go through its attitude."""
    there = tmp_path / "legs.sdf"
    pose = ["--set", "initial={position: [0.3, 0.2, 1.4], orientation: {rpy: [0.1, -0.2, 0.3]}}"]
    arguments = ["export", str(ROOT / "scenarios/caroca.yaml"), "--to", "sdf", "--style", "legs", *pose]
    done = CliRunner().invoke(cli, [*arguments, "--sdf-version", version, "--out", str(there)])
    assert done.exit_code == 0, done.output
    back, _ = robot_of(tmp_path, there.read_text())
    robot = cdpr.load_robot(ROOT / "scenarios/robots/caroca.yaml")
    np.testing.assert_allclose(back.anchors, robot.anchors, atol=1e-12)
    np.testing.assert_allclose(back.platform.inertia, robot.platform.inertia, atol=1e-12)
    assert (back.platform.mass, back.tension_max.tolist()) == (robot.platform.mass, robot.tension_max.tolist())
    np.testing.assert_allclose(back.home[:3], [0.3, 0.2, 1.4], atol=1e-15)


def test_a_weld_to_what_is_not_there_is_refused(tmp_path):
    weld = "<child_model>__model__</child_model><child_link>platform</child_link><parent_link>foot</parent_link>"
    system = (
        f'<plugin filename="gz-sim-detachable-joint-system" name="gz::sim::systems::DetachableJoint">{weld}</plugin>'
    )
    with pytest.raises(
        FormatError, match="plugin 'gz::sim::systems::DetachableJoint' joins the link 'foot', which does not"
    ):
        robot_of(tmp_path, text().replace("    <plugin", f"{system}    <plugin", 1))
    robot_of(tmp_path, text().replace("    <plugin", f"{system.replace('__model__', 'load')}    <plugin", 1))
