"""Rejections, omissions and protection of existing files in exports, with their messages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from export_cases import ROBOTS, subject_of

from cdpr.base.errors import CdprError, FormatError, PartsLeftOut
from cdpr.formats.write.export import export as export_verb
from cdpr.formats.write.export_model import Options, export
from cdpr.model import rotations


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("robots/caroca.yaml", "--to", "sdf", "--style", "sticks"), 2, "style: expected one of platform, legs"),
        (
            ("robots/caroca.yaml", "--to", "sdf", "--sdf-version", "2"),
            2,
            "version: expected one of 1.9, 1.6",
        ),
        (("robots/caroca.yaml", "--to", "mjcf", "--style", "legs"), 2, "--style is for --to sdf"),
        (
            ("robots/planar.yaml", "--to", "sdf", "--style", "legs"),
            2,
            "in all six directions; robot 'planar' is not",
        ),
        (("winch.yaml", "--to", "mjcf"), 2, "MJCF does not support winches and elastic cables: cable_1, cable_2"),
        (
            ("camera_robot.yaml", "--to", "mjcf"),
            2,
            "--set robot.winch.type=torque, of a robot file cable.model=ideal and winch.type=torque)",
        ),
        (("cogiro_pulleys.yaml", "--to", "mjcf"), 2, "replace them by points (--pulleys-as-points)"),
        (("robots/caroca.yaml", "--to", "urdf", "--pulleys-as-points"), 2, "is for --to mjcf or --to sdf"),
        (
            ("robots/caroca.yaml", "--to", "csv"),
            2,
            "csv is for runs, and this is a file of a robot or scenario: mjcf, sdf, urdf, ros2",
        ),
        (("robots/carocca.yaml", "--to", "urdf"), 2, "carocca.yaml': did you mean"),
        (("robots", "--to", "urdf"), 2, "urdf is for robots and scenarios, and this is a run"),
    ],
)
def test_unsupported_exports_are_reported(tmp_path, words, code, said):
    file, *rest = words
    done = cdpr_here("export", ROOT / "scenarios" / file, *rest, code=None, cwd=tmp_path)
    assert done.returncode == code
    assert said in done.stderr
    assert list(Path(tmp_path).iterdir()) == []


def test_nothing_is_written_over(tmp_path):
    words = ("export", ROBOTS / "caroca.yaml", "--to", "urdf")
    assert cdpr_here(*words, cwd=tmp_path).stdout == "caroca.urdf\n"
    before = (tmp_path / "caroca.urdf").read_bytes()
    done = cdpr_here(*words, code=8, cwd=tmp_path)
    assert "'caroca.urdf' already exists" in done.stderr
    cdpr_here(*words, "--force", cwd=tmp_path)
    assert (tmp_path / "caroca.urdf").read_bytes() == before


def test_winches_may_be_left_out(tmp_path):
    words = ("export", ROOT / "scenarios" / "winch.yaml", "--to", "mjcf", "--set", "robot.cable.model=ideal")
    cdpr_here(*words, cwd=tmp_path)
    assert len(list(tmp_path.iterdir())) == 1


def test_unknown_formats_are_reported():
    with pytest.raises(FormatError, match="got 'sfd'; did you mean 'sdf'"):
        export(subject_of("planar"), "sfd")


@pytest.mark.parametrize("to", ["sdf", "urdf"])
def test_parts_of_cables_that_are_left_out_are_reported(tmp_path, to):
    rolled = cdpr_here("export", ROBOTS / "cogiro_pulleys.yaml", "--to", to, cwd=tmp_path)
    assert "left out: pulleys of cable_1, cable_2" in rolled.stderr
    wound = cdpr_here("export", ROOT / "scenarios" / "winch.yaml", "--to", to, cwd=tmp_path)
    assert "left out: winches and elasticity of cable_1, cable_2" in wound.stderr
    assert cdpr_here("export", ROBOTS / "caroca.yaml", "--to", to, cwd=tmp_path).stderr == ""
    driven = (
        "export",
        ROOT / "scenarios" / "winch_fmu.yaml",
        "--set",
        "robot.cable.model=ideal",
        "--to",
        to,
        "--force",
    )
    assert "left out: actuators" in cdpr_here(*driven, cwd=tmp_path).stderr
    eventful = cdpr_here("export", ROOT / "scenarios" / "cable_break.yaml", "--to", to, "--force", cwd=tmp_path)
    assert "left out: events: not exported (cable_break at 1 s)" in eventful.stderr


@pytest.mark.parametrize(("to", "floats"), [("mjcf", False), ("sdf", False), ("urdf", True)])
def test_an_unexpected_floating_platform_is_reported(tmp_path, to, floats):
    done = cdpr_here("export", ROBOTS / "planar.yaml", "--to", to, cwd=tmp_path)
    assert ("left out: the guide that leaves x, z, ry free: the platform floats there" in done.stderr) == floats


def test_packages_for_ros_2_are_of_scenarios(tmp_path):
    done = cdpr_here("export", ROOT / "scenarios" / "caroca.yaml", "--to", "ros2", "--out", tmp_path / "out")
    assert "20 files" in done.stdout  # 7 of them of the controller in C++
    assert (tmp_path / "out" / "cdpr_caroca" / "package.xml").is_file()
    again = cdpr_here("export", ROOT / "scenarios" / "caroca.yaml", "--to", "ros2", "--out", tmp_path / "out", code=8)
    assert "exists already and is not empty" in again.stderr
    robot = cdpr_here("export", ROBOTS / "caroca.yaml", "--to", "ros2", code=2)
    assert "ros2 requires a scenario" in robot.stderr
    assert "'cdpr new scenario --robot FILE' writes one" in robot.stderr


def test_bodies_too_light_for_mujoco_are_reported():
    mujoco = pytest.importorskip("mujoco")
    subject = subject_of("caroca")
    for least, sound in ((1.01e-15, True), (1e-15, False)):
        platform = replace(subject.robot.platform, inertia=least * np.eye(3))
        light = replace(subject, robot=replace(subject.robot, platform=platform))
        if sound:
            mujoco.MjModel.from_xml_string(export(light, "mjcf"))
        else:
            with pytest.raises(FormatError, match=r"above 1e-15 .* the smallest of the platform is 1e-15"):
                export(light, "mjcf")


def test_legs_have_a_length():
    subject = subject_of("caroca")
    first = subject.robot.cables[0]
    end = subject.state[:3] + rotations.matrix(subject.state[3:7]) @ first.platform
    robot = replace(subject.robot, cables=(replace(first, frame=end), *subject.robot.cables[1:]))
    with pytest.raises(CdprError, match=f"cable '{first.name}' has no length"):
        export(replace(subject, robot=robot), "sdf", Options("legs"))


def test_unwritable_folders_are_reported(tmp_path):
    (tmp_path / "file").write_text("kept")
    for out in ("file/robot.xml", "file/deeper/robot.xml"):
        done = cdpr_here("export", ROBOTS / "caroca.yaml", "--to", "mjcf", "--out", out, code=8, cwd=tmp_path)
        assert "cannot be written" in done.stderr
    assert (tmp_path / "file").read_text() == "kept"


@pytest.mark.parametrize("to", ["mjcf", "sdf"])
def test_pulleys_can_be_replaced_by_points(tmp_path, to):
    """The same text as of a robot with points in their place."""
    robot = ROOT / "scenarios" / "cogiro_pulleys.yaml"
    style = () if to == "mjcf" else ("--style", "legs")
    done = cdpr_here("export", robot, "--to", to, *style, "--pulleys-as-points", "--out", tmp_path / "a", code=0)
    assert "left out: pulleys of " in done.stderr
    points = [f"--set=robot.cables[{k}].exit={{type: point}}" for k in range(8)]
    cdpr_here("export", robot, "--to", to, *style, *points, "--out", tmp_path / "b", code=0)
    assert (tmp_path / "a").read_text() == (tmp_path / "b").read_text()


@pytest.mark.parametrize("to", ["urdf", "native"])
def test_the_command_and_the_python_interface_write_and_report_the_same(to, tmp_path):
    scenario = ROOT / "scenarios" / "cable_break.yaml"
    with pytest.warns(PartsLeftOut) as caught:
        ours = export_verb(scenario, to, tmp_path / "python")
    done = cdpr_here("export", scenario, "--to", to, "--out", tmp_path / "command")
    files = sorted(path.relative_to(ours) for path in ours.rglob("*")) if ours.is_dir() else [Path()]
    assert files
    for name in files:
        assert (tmp_path / "command" / name).read_bytes() == (ours / name).read_bytes()
    assert [str(each.message) for each in caught] == done.stderr.splitlines()
