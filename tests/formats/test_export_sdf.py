"""Robots exported as SDF: the checker of libsdformat, legs, and reserved names."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from export_cases import NAMES, subject_of

from cdpr.formats.write.export_model import Options, export
from cdpr.mechanics.kinematics import lengths, wrench_matrix
from cdpr.model import rotations

CHECKER = shutil.which("ign") or shutil.which("gz")


@pytest.mark.skipif(CHECKER is None, reason="needs libsdformat's checker (Debian: ignition-tools, libsdformat-dev)")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("style", ["platform", "legs"])
@pytest.mark.parametrize("version", ["1.9", "1.6"])
def test_libsdformat_finds_nothing_wrong(tmp_path, name, style, version):
    subject = subject_of(name)
    if style == "legs" and subject.robot.n < 6:
        pytest.skip("legs are for platforms that are free")
    file = tmp_path / "robot.sdf"
    file.write_text(export(subject, "sdf", Options(style, version)))
    done = subprocess.run([CHECKER, "sdf", "-k", str(file)], capture_output=True, text=True, check=False)
    assert "Valid." in done.stdout, done.stdout + done.stderr
    assert "Warning" not in done.stdout + done.stderr


def test_legs_end_where_cables_do():
    """The axis leads from the frame's anchor along z of the leg, with the cable's length; no world axes."""
    subject = subject_of("caroca")
    root = ET.fromstring(export(subject, "sdf", Options("legs")))
    far = lengths(subject.robot, subject.state)
    R = rotations.matrix(subject.state[3:7])
    for cable, length in zip(subject.robot.cables, far, strict=True):
        poses = {}
        for part in ("lower", "upper"):
            link = root.find(f".//link[@name='{cable.name}_{part}']")
            numbers = np.array([float(word) for word in link.find("pose").text.split()])
            poses[part] = numbers[:3], rotations.matrix(rotations.from_rpy(*numbers[3:]))
        end = subject.state[:3] + R @ cable.platform
        assert np.allclose(poses["lower"][0], cable.frame, atol=1e-12)
        assert np.allclose(poses["upper"][0], end, atol=1e-12)
        assert np.allclose(poses["lower"][0] + length * poses["lower"][1][:, 2], end, atol=1e-9)
        limit = root.find(f".//joint[@name='{cable.name}_slide']/axis/limit")
        reach = [length + float(limit.find(side).text) for side in ("lower", "upper")]
        assert np.allclose(reach, [0.0, 2.0 * np.linalg.norm(np.ptp(subject.robot.anchors[:, :3], axis=0))])
        for part in ("lower", "upper"):
            moments = [float(root.find(f".//link[@name='{cable.name}_{part}']//i{a}{a}").text) for a in "xyz"]
            assert max(moments) <= sum(moments) - max(moments) + 1e-15


@pytest.mark.skipif(CHECKER is None, reason="needs libsdformat's checker (Debian: ignition-tools, libsdformat-dev)")
@pytest.mark.parametrize("name", ["world", "sun", "physics", "__r__", "frame", "platform"])
@pytest.mark.parametrize("style", ["platform", "legs"])
def test_names_that_sdf_reserves_are_no_trouble(tmp_path, name, style):
    subject = subject_of("caroca")
    names = ["world", "sun", "frame", "a", "a_frame", "platform", "physics", "fixed"]
    cables = [replace(cable, name=each) for cable, each in zip(subject.robot.cables, names, strict=True)]
    robot = replace(subject.robot, name=name, cables=tuple(cables))
    file = tmp_path / "robot.sdf"
    file.write_text(export(replace(subject, robot=robot), "sdf", Options(style)))
    done = subprocess.run([CHECKER, "sdf", "-k", str(file)], capture_output=True, text=True, check=False)
    assert "Valid." in done.stdout, done.stdout + done.stderr
    assert "Warning" not in done.stdout + done.stderr


def as_old(text):
    """An SDF of 1.9 as DART's reader takes it, without systems, and which links are welded by one."""
    root = ET.fromstring(text)
    root.set("version", "1.6")
    welds = []
    for parent in list(root.iter()):
        for plugin in parent.findall("plugin"):
            if plugin.get("name") == "gz::sim::systems::DetachableJoint":
                assert plugin.findtext("child_model") == "__model__"
                welds.append((plugin.findtext("parent_link"), plugin.findtext("child_link")))
            parent.remove(plugin)
    return ET.tostring(root, encoding="unicode"), welds


def test_each_foot_is_welded_and_let_go_by_a_topic_of_its_own():
    subject = subject_of("caroca")
    text = export(subject, "sdf", Options("legs"))
    root = ET.fromstring(text)
    names = [cable.name for cable in subject.robot.cables]
    assert as_old(text)[1] == [(f"{name}_foot", "platform") for name in names]
    assert [each.text for each in root.iter("detach_topic")] == [f"/model/caroca/{name}/detach" for name in names]
    assert not [joint for joint in root.iter("joint") if joint.findtext("child") == "platform"]
    links = [link.get("name") for link in root.iter("link")]
    children = [joint.findtext("child") for joint in root.iter("joint")]
    assert sorted(children) == sorted(set(links) - {"platform"})  # no link hangs on two joints, which DART's refuses


@pytest.mark.parametrize("version", ["1.6", "1.9"])
def test_legs_pull_as_cables_do(tmp_path, monkeypatch, version):
    """DART with the loops closed: with minus the tensions in the slides, that of W t.

    Of 1.6 those that its reader opened, by balls; of 1.9 by welds, as gz-sim's system does.
    """
    dart = pytest.importorskip("dartpy")
    monkeypatch.setattr("cdpr.formats.write.legs.MASS", 1e-6)  # kg: what legs weigh does not matter here
    subject = subject_of("off_centre")
    robot, state = subject.robot, subject.state
    file = tmp_path / "legs.sdf"
    text, welds = as_old(export(subject, "sdf", Options("legs", version)))
    file.write_text(text)
    world = dart.utils.SdfParser.readWorld(f"file://{file}")
    legs = world.getSkeleton(0)
    platform = legs.getBodyNode("platform")
    joints = {legs.getJoint(k).getName() for k in range(legs.getNumJoints())}
    R = rotations.matrix(state[3:7])
    close = world.getConstraintSolver().addConstraint
    for foot, other in welds:
        close(dart.constraint.WeldJointConstraint(legs.getBodyNode(foot), legs.getBodyNode(other)))
    for cable in robot.cables:
        if f"{cable.name}_ball" not in joints:
            place = state[:3] + R @ cable.platform
            upper = legs.getBodyNode(f"{cable.name}_upper")
            close(dart.constraint.BallJointConstraint(upper, platform, place))
    # The frame is fixed, and of 1.6 one ball joint is left; of 1.9 all are, and the platform floats.
    assert len(joints) == (2 * robot.m + 2 if version == "1.6" else 3 * robot.m + 2)
    tension = np.linspace(300.0, 500.0, robot.m)
    world.setTimeStep(1e-4)
    for cable, force in zip(robot.cables, tension, strict=True):
        legs.getDof(f"{cable.name}_slide").setForce(-force)
    world.step()
    body = robot.platform
    r = R @ body.center_of_mass
    wrench = wrench_matrix(robot, state) @ tension
    turning = np.linalg.solve(R @ body.inertia @ R.T, wrench[3:] - np.cross(r, wrench[:3]))
    moving = wrench[:3] / body.mass + subject.gravity - np.cross(turning, r)
    assert np.allclose(np.ravel(platform.getAngularVelocity()) / 1e-4, turning, atol=1e-3)
    assert np.allclose(np.ravel(platform.getLinearVelocity()) / 1e-4, moving, atol=1e-3)


@pytest.mark.skipif(CHECKER is None, reason="needs libsdformat's checker (Debian: ignition-tools, libsdformat-dev)")
@pytest.mark.parametrize(("robot", "style"), [("caroca", "legs"), ("planar", "platform"), ("spherical", "platform")])
def test_tools_may_be_called_as_parts_of_sdf_are(tmp_path, robot, style):
    subject = subject_of(robot)
    names = ["fixed", "guide", "guide_1", "carriage_1", "tool_guide", "__t__"]
    names += [
        f"{subject.robot.cables[0].name}_{part}" for part in ("lower", "upper", "slide", "ball", "universal", "foot")
    ]
    tools = {name: np.array([0.1 * k, 0.0, 0.0]) for k, name in enumerate(names)}
    platform = replace(subject.robot.platform, tools=tools)
    text = export(replace(subject, robot=replace(subject.robot, platform=platform)), "sdf", Options(style))
    (tmp_path / "robot.sdf").write_text(text)
    done = subprocess.run([CHECKER, "sdf", "-k", tmp_path / "robot.sdf"], capture_output=True, text=True, check=False)
    assert "Valid." in done.stdout, done.stdout + done.stderr
    assert len([each for each in ET.fromstring(text).iter("frame") if each.find("pose") is not None]) >= len(names)
