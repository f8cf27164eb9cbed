"""MJCF: meaning of its numbers, verified by MuJoCo's own forces; export and import are inverses."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from command_line import cdpr_here
from mjcf_cases import SAME, SKY, compiled, mujoco, random_states, robot_of, taken

from cdpr.base.errors import FormatError, PluginError
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.mechanics.properties import home_pose
from cdpr.model import rotations

ACTUATOR = '<motor name="r" tendon="right" gear="-2" ctrllimited="true" ctrlrange="0 1"/>'
BODY = '<geom type="box" size="0.2 0.1 0.05" density="1000" rgba="1 0 0 1"/>'
RIGHT = '<spatial name="right" class="rope"><site site="b2"/><site site="a2"/></spatial>'
MODEL = f"""<mujoco model="My robot">
  <compiler angle="degree" meshdir="nowhere"/>
  <default><site size="0.01"/><default class="rope"><tendon width="0.01"/></default></default>
  <asset>{SKY}<material name="m" rgba="1 0 0 1"/></asset>
  <option gravity="0 0 -9.81"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1" material="m"/>
    <body name="mast" pos="2 0 0"><site name="a1" pos="0 0 3"/></body>
    <site name="a2" pos="-2 0 3"/>
    <body name="load" pos="0.5 0 1" euler="0 0 90">
      <freejoint/>
      {BODY}
      <site name="b1" pos="0 0.1 0.3"/>
      <site name="b2" pos="0 -0.1 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="left" width="0.002"><site site="a1"/><site site="b1"/></spatial>
    {RIGHT}
  </tendon>
  <actuator>
    {ACTUATOR}
    <general name="l" tendon="left" gainprm="10" ctrllimited="true" ctrlrange="-5 0" forcelimited="true"
      forcerange="-30 10"/>
  </actuator>
  <sensor><actuatorfrc actuator="r"/></sensor>
</mujoco>
"""


def test_the_mujoco_page_matches_its_results(tmp_path):
    """Forces of MuJoCo's tendons on its free joint, moments in the body's axes, at other controls than ours."""
    robot = robot_of(tmp_path, MODEL)
    model, data = compiled(MODEL)
    for state in random_states(20):
        data.qpos[:] = state[:7]
        data.ctrl[:] = (0.5, -2.0)
        mujoco.mj_forward(model, data)
        wrench = wrench_matrix(robot, state) @ np.array([1.0, 20.0])
        assert np.allclose(data.qfrc_actuator[:3], wrench[:3], atol=1e-9)
        assert np.allclose(data.qfrc_actuator[3:], rotations.matrix(state[3:7]).T @ wrench[3:], atol=1e-9)


def test_numbers_and_where_they_came_from(tmp_path):
    found = taken(tmp_path, MODEL)
    robot = robot_of(tmp_path, MODEL)
    assert robot.name == "My_robot"
    assert [cable.name for cable in robot.cables] == ["right", "left"]  # the order of the controls
    assert robot.tension_max.tolist() == [2.0, 30.0]
    assert [cable.diameter for cable in robot.cables] == [0.02, 0.004]
    assert robot.anchors.tolist() == [[-2.0, 0.0, 3.0, 0.0, -0.1, 0.0], [2.0, 0.0, 3.0, 0.0, 0.1, 0.3]]
    a, b, c = 0.4, 0.2, 0.1
    assert robot.platform.mass == pytest.approx(1000 * a * b * c)
    wanted = 8 / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.allclose(robot.platform.inertia, np.diag(wanted), rtol=SAME)
    assert robot.platform.shape.size == (a, b, c)
    assert robot.platform.colour == "#ff0000"
    assert np.allclose(robot.home, [0.5, 0.0, 1.0, 0.5**0.5, 0.0, 0.0, 0.5**0.5])
    text = found.files["My_robot.yaml"]
    assert "mass: 8.0  # kg, of body 'load', line 10" in text
    assert "# model.xml:18: tendon 'left': a control of 1 is a tension of -10 N there" in text
    assert text == taken(tmp_path, MODEL).files["My_robot.yaml"]


@pytest.mark.parametrize(("site", "tool"), [("world", "world_2"), ("left_frame", "left_frame_2"), ("left", "left")])
def test_sites_that_are_called_as_parts_of_exports_are_get_a_number(tmp_path, site, tool):
    robot = robot_of(tmp_path, MODEL.replace('<site name="b2"', f'<site name="{site}" pos="0 0 1"/><site name="b2"'))
    assert {name: point.tolist() for name, point in robot.platform.tools.items()} == {tool: [0.0, 0.0, 1.0]}


@pytest.mark.parametrize(("gear", "highest"), [(-1, 4.0), (-2, 8.0), (1, 1.5)])
def test_a_range_of_forces_of_a_tendon_is_that_of_its_actuators(tmp_path, gear, highest):
    """As MuJoCo has it: of the actuators' forces, before their gear."""
    limited = RIGHT.replace("<spatial", '<spatial actuatorfrclimited="true" actuatorfrcrange="-1.5 4"')
    motor = f'<motor name="r" tendon="right" gear="{gear}" ctrllimited="true" ctrlrange="-100 100"/>'
    text = MODEL.replace(RIGHT, limited).replace(ACTUATOR, motor)
    robot = robot_of(tmp_path, text)
    assert robot.tension_max[0] == highest
    model, data = compiled(text)
    data.ctrl[:] = (-100.0 * gear, 0.0)
    mujoco.mj_forward(model, data)
    pull = wrench_matrix(robot, np.concatenate([data.qpos, np.zeros(6)])) @ np.array([highest, 0.0])
    assert np.allclose(data.qfrc_actuator[:3], pull[:3], atol=1e-9)


@pytest.mark.parametrize(
    "inertia",
    [
        '<inertial pos="0.1 0 0" mass="3" diaginertia="0.1 0.2 0.25"/>',
        '<inertial pos="0.1 0 0" mass="3" fullinertia="0.1 0.2 0.25 0 0 0"/>',
        '<inertial pos="0.1 0 0" mass="3" diaginertia="0.2 0.1 0.25" euler="0 0 90"/>',
        '<geom pos="0.1 0 0" size="9" mass="0"/><inertial pos="0.1 0 0" mass="3" diaginertia="0.1 0.2 0.25"/>',
        '<inertial pos="0 0 0" mass="1" diaginertia="0.05 0.1 0.1"/><body name="rest" pos="0.15 0 0">'
        '<inertial pos="0 0 0" mass="2" diaginertia="0.05 0.085 0.135"/></body>',
        '<geom type="mesh" mesh="look"/><inertial pos="0.1 0 0" mass="3" diaginertia="0.1 0.2 0.25"/>',
    ],
)
def test_inertia_in_any_way(tmp_path, inertia):
    """That of two bodies: 1 kg at 0 and 2 kg at 0.15 m are 3 kg at 0.1 m, and 0.015 kg m^2 more about y and z."""
    platform = robot_of(tmp_path, MODEL.replace(BODY, inertia)).platform
    assert platform.mass == 3.0
    assert np.allclose(platform.center_of_mass, [0.1, 0.0, 0.0], atol=SAME)
    assert np.allclose(platform.inertia, np.diag([0.1, 0.2, 0.25]), atol=SAME)


@pytest.mark.parametrize(
    ("joints", "dof", "place"),
    [
        ('<joint type="slide" axis="1 0 0"/>', ("y",), [0.5, 0.0, 1.0]),  # the body is turned by 90 degrees about z
        ('<joint type="slide" axis="0 0 2"/><joint type="slide" axis="0 -1 0"/>', ("x", "z"), [0.5, 0.0, 1.0]),
        (
            '<joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 0 1" pos="0.1 0 0"/>',
            ("z", "rz"),
            [0.5, 0.1, 1.0],
        ),
        ('<joint type="hinge" axis="0 1 0" pos="0 3 0"/>', ("rx",), [0.5, 0.0, 1.0]),  # on its axis
        ('<joint type="ball" pos="0 0 0.2"/>', ("rx", "ry", "rz"), [0.5, 0.0, 1.2]),
    ],
)
def test_joints_are_directions(tmp_path, joints, dof, place):
    robot = robot_of(tmp_path, MODEL.replace("<freejoint/>", joints))
    assert robot.dof == dof
    pose = home_pose(robot)[0]
    if joints.startswith('<joint type="hinge"'):
        assert pose[1:3].tolist() == pytest.approx(place[1:])  # any point of the axis
    else:
        assert pose[:3].tolist() == pytest.approx(place)
    model, data = compiled(MODEL.replace("<freejoint/>", joints))
    data.ctrl[:] = (0.5, -2.0)
    mujoco.mj_forward(model, data)
    R = rotations.matrix(pose[3:])
    for row, name in zip(robot.anchors, ("b2", "b1"), strict=True):
        assert np.allclose(pose[:3] + R @ row[3:], data.site(name).xpos, atol=SAME)
    wrench = wrench_matrix(robot, make_state(pose[:3], pose[3:])) @ np.array([1.0, 20.0])
    if "ball" in joints:
        wanted = data.body("load").xmat.reshape(3, 3).T @ wrench[3:]
    else:
        parts = [3 if kind == mujoco.mjtJoint.mjJNT_HINGE else 0 for kind in model.jnt_type]
        wanted = [axis @ wrench[k : k + 3] for axis, k in zip(data.xaxis, parts, strict=True)]
    assert np.allclose(data.qfrc_actuator, wanted, atol=1e-9)


def test_a_keyframe_is_home(tmp_path):
    key = '<keyframe><key name="up" qpos="0 1 2 1 0 0 0" ctrl="0.1 0.2"/></keyframe></mujoco>'
    found = taken(tmp_path, MODEL.replace("</mujoco>", key))
    robot = robot_of(tmp_path, MODEL.replace("</mujoco>", key))
    assert robot.home.tolist() == [0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 0.0]
    assert "keyframe 'up'" in found.files["My_robot.yaml"]


def test_controls_that_push_make_legs(tmp_path):
    text = MODEL.replace('ctrlrange="0 1"', 'ctrlrange="-1 1"')
    robot = robot_of(tmp_path, text)
    assert not robot.unilateral
    assert robot.tension_min.tolist() == [-2.0, 0.0]
    assert [each for each in taken(tmp_path, text).warnings if "may push with 2 N: unilateral is set to false" in each]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            BODY,
            f'{BODY}<body name="arm"><joint/><geom size="0.1"/><site name="a2"/></body>',
            "body 'arm' is a second moving body, besides 'load', on which cables end",
        ),
        ("<freejoint/>", "", "no moving body"),
        ("<freejoint/>", '<joint type="slide" axis="1 1 0"/>', ":11: axis: expected x, y or z of the world"),
        ("<freejoint/>", '<joint/><joint axis="0 1 0"/>', "turns with the hinge before it"),
        ("<freejoint/>", '<joint type="hinge"/><joint type="slide"/>', "this slide turns with the hinge"),
        ("<freejoint/>", '<joint type="slide"/><joint type="slide"/>', "a second slide along z"),
        ("<freejoint/>", '<joint type="ball"/><joint type="slide"/>', "no equivalent guide"),
        (
            '<site site="b2"/><site site="a2"/>',
            '<site site="b2"/><geom geom="floor2"/><site site="a2"/>',
            "around the geom 'floor2'",
        ),
        (
            '<site site="b2"/>',
            '<site site="b2"/><site site="b1"/>',
            ":19: tendon 'right': it has 3 sites, and 'a2' is a third",
        ),
        ('<site site="b2"/>', '<site site="a1"/>', "tendon 'right': expected one site on each, got both on the frame"),
        ('<site site="a2"/>', '<site site="b1"/>', "expected one site on each, got both on body 'load'"),
        (ACTUATOR, "", ":19: tendon 'right': it has no motor"),
        (ACTUATOR, '<motor tendon="right" gear="-1"/>', "no limit of its control or force"),
        (ACTUATOR, '<motor tendon="right" ctrllimited="true" ctrlrange="0 5"/>', "it only pushes"),
        (
            ACTUATOR,
            '<position name="p" tendon="right" kp="3"/>',
            ":19: tendon 'right': its servo has no limited force, so no limited tension: add forcerange=",
        ),
        (
            ACTUATOR,
            '<general tendon="right" biastype="affine" biasprm="0 -3"/>',
            "its servo has no limited force",
        ),
        (ACTUATOR, '<muscle name="m" tendon="right"/>', ":22: <muscle> 'm': expected motor, general or a servo"),
        (
            ACTUATOR,
            '<general tendon="right" dyntype="integrator"/>',
            "its own gain, bias or dynamics",
        ),
        (ACTUATOR, f'{ACTUATOR}<motor tendon="right"/>', "expected one motor, got two"),
        (RIGHT, RIGHT.replace('class="rope"', 'stiffness="5"'), "it is a spring: describe"),
        (RIGHT, '<fixed name="right"><joint joint="slider" coef="1"/></fixed>', "got a <fixed> tendon"),
        (
            BODY,
            '<inertial pos="nan 0 0" mass="3" diaginertia="1 1 1"/>',
            ":12: pos of <inertial>: expected numbers of at most 1e+12",
        ),
        (
            BODY,
            '<inertial pos="0 0 0" mass="-Inf" diaginertia="1 1 1"/>',
            ":12: mass of <inertial>: expected numbers of at most",
        ),
        (BODY, '<inertial pos="0 1e300 0" mass="3" diaginertia="1 1 1"/>', "got '0 1e300 0'"),
        (BODY, '<geom type="mesh" mesh="look"/><geom size="0.1"/>', ":12: body 'load' takes its inertia from a mesh"),
        (
            "<option",
            '<include file="/etc/passwd"/><option',
            ":5: <include>: '/etc/passwd' is outside the folder of the model",
        ),
        ("<option", '<equality><weld name="w" body1="load"/></equality><option', "<weld> 'w'"),
        (BODY, f'<replicate count="1000000000">{BODY}</replicate>', "<replicate>: it creates copies"),
        ("<freejoint/>", "<freejoint/><plugin/>", "<plugin>: the file does not define the behaviour of a plugin"),
        ("<freejoint/>", "<freejoint/><joint/>", "MuJoCo does not compile it"),
        (BODY, '<geom size="1e200" density="1e200"/>', ":12: size of <geom>: expected numbers of at most 1e+12"),
        (BODY, '<geom size="1e4" density="1e12"/>', ":10: the robot is invalid: platform.mass"),
        ('euler="0 0 90"', 'euler="0 0 ninety"', ":10: MuJoCo does not compile it"),
        ("<mujoco", '<!DOCTYPE mujoco [<!ENTITY a "b">]><mujoco', "entities are not resolved"),
        ("<mujoco", "<mujocoinclude", "invalid XML"),
    ],
)
def test_rejected_input_is_reported_with_its_line(tmp_path, old, new, said):
    assert old in MODEL
    text = MODEL.replace(old, new)
    if "floor2" in new:
        text = text.replace('<site name="a2"', '<geom name="floor2" size="0.1"/><site name="a2"')
    if "slider" in new:
        text = text.replace("<freejoint/>", '<joint name="slider" type="slide"/>')
    with pytest.raises(FormatError) as raised:
        taken(tmp_path, text)
    assert said in str(raised.value)
    assert str(raised.value).startswith(str(tmp_path / "model.xml"))
    assert "\n" not in str(raised.value)


def test_omitted_content_is_reported(tmp_path):
    text = MODEL.replace("<freejoint/>", '<joint type="slide" damping="1" range="-1 1" limited="true"/>')
    text = text.replace('gravity="0 0 -9.81"', 'gravity="0 0 -1.62" viscosity="1"').replace(
        'width="0.002"', 'range="0 9" limited="true" damping="3"'
    )
    text = text.replace(ACTUATOR, f'{ACTUATOR}<adhesion name="extra" body="load" ctrlrange="0 1"/>')
    told = taken(tmp_path, text).left_out
    for said in (
        ":11: damping of a joint",
        ":11: range of a joint",
        ":5: gravity [0.0, 0.0, -1.62]",
        "viscosity",
        ":18: damping of tendon 'left'",
        ":18: range of a tendon",
        ":22: <adhesion> 'extra': it drives no tendon",
    ):
        assert [each for each in told if said in each], said
    assert robot_of(tmp_path, text).cables[1].length_max == 9.0


def test_it_is_a_command_like_others(tmp_path):
    (tmp_path / "model.xml").write_text(MODEL)
    (tmp_path / "part.xml").write_text("<mujocoinclude/>")
    (tmp_path / "wrong.xml").write_text(MODEL.replace("<freejoint/>", ""))
    done = cdpr_here("import", tmp_path, "--out", tmp_path / "out")
    assert "1 of 2 could be read" in done.stdout
    cdpr_here("validate", tmp_path / "out" / "My_robot.yaml")
    done = cdpr_here("import", tmp_path / "part.xml", code=2)
    assert "part.xml:1: it is a part that other files include" in done.stderr


def test_without_mujoco_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(PluginError, match=r"pip install 'cdpr\[mujoco\]'"):
        taken(tmp_path, MODEL)
