"""Skeleton of packages for ROS 2: its files, and its Python with stand-ins for the interfaces of ROS."""

from __future__ import annotations

import os
import re
import runpy
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import setuptools
import yaml
from conftest import ROOT
from native_compiler import tool
from ros2_stand_ins import TYPES, Node, Request, install

import cdpr
from cdpr.base.errors import FormatError, OutputError
from cdpr.formats.write import ros2
from cdpr.formats.write.native import native_files
from cdpr.formats.write.ros2 import package_name, packages, write_ros2
from cdpr.ui.gui.outgoing import exported

SCENARIO = ROOT / "scenarios" / "caroca.yaml"
NAME = "cdpr_caroca"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("ros") / "src"
    write_ros2(cdpr.load_scenario(SCENARIO), place)
    return place


@pytest.fixture
def node(folder, monkeypatch):
    """Return a node of the generated module, and its module, with parameters as given."""
    made = []

    def make(**given):
        monkeypatch.setattr(Node, "given", given)
        install(monkeypatch, NAME, folder / NAME, made.append)
        module = runpy.run_path(str(folder / NAME / NAME / "node.py"))
        made.append(module["CdprNode"]())
        return made[-1]

    yield make
    for each in made:
        each.close()


def wrench(force, torque=(0.0, 0.0, 0.0)):
    message = TYPES["geometry_msgs.msg"]["WrenchStamped"]()
    for part, values in ((message.wrench.force, force), (message.wrench.torque, torque)):
        part.x, part.y, part.z = values
    return message


def test_it_reports_the_pose_of_the_platform(node):
    made = node(rate=50.0)
    assert made.timer.period == 0.02
    for _ in range(5):
        made.timer.tick()
    with cdpr.Simulation(SCENARIO) as simulation:
        simulation.until(0.1)
        row, columns = simulation.row, simulation.so_far().header.layout.columns
    sent = {topic: publisher.sent for topic, publisher in made.published.items()}
    assert {len(messages) for messages in sent.values()} == {5}
    pose, cables, transform = sent["platform/pose"][-1], sent["cables"][-1], sent["/tf"][-1].transforms[0]
    place = pose.pose.position
    assert [place.x, place.y, place.z] == row[columns["position"]].tolist()
    turn = transform.transform.rotation
    assert [turn.w, turn.x, turn.y, turn.z] == row[columns["orientation"]].tolist()
    assert (pose.header.frame_id, transform.child_frame_id) == ("world", "platform")
    assert cables.effort == row[columns["tension"]].tolist()
    assert cables.position == row[columns["length"]].tolist()
    assert len(cables.name) == len(cables.velocity) == 8
    stamp = sent["/clock"][-1].clock
    assert stamp.sec + stamp.nanosec * 1e-9 == pytest.approx(row[columns["time"]][0], abs=1e-9)


def test_a_wrench_acts_until_the_next(node):
    ends = []
    for forces in ([], [(400.0, 0.0, 0.0)], [(400.0, 0.0, 0.0), (0.0, 0.0, 0.0)], [(np.nan, 0.0, 0.0)]):
        made = node()
        made.timer.tick()
        for force in forces:
            made.subscribed["external_wrench"](wrench(force))
        for _ in range(10):
            made.timer.tick()
        ends.append(made.published["platform/pose"].sent[-1].pose.position.x)
        assert bool(made.said) == bool(forces and np.isnan(forces[0][0]))
    assert ends[1] > ends[0] + 1e-4
    assert ends[2] == pytest.approx(ends[0], abs=1e-9)
    assert ends[3] == ends[0]


def test_the_service_distributes_as_cdpr_does(node):
    made = node()
    request = Request()
    request.pose.position.z, request.pose.orientation.w = 1.2, 1.0
    request.wrench.force.z = 1500.0
    answer = made.services["distribute_wrench"](request)
    scenario = cdpr.load_scenario(SCENARIO)
    expected = cdpr.distribute(
        scenario.robot, [0, 0, 1.2, 1, 0, 0, 0], [0, 0, 1500, 0, 0, 0], solver=scenario.solver.type
    )
    assert answer.feasible
    assert answer.tension == expected.tension.tolist()
    request.wrench.force.z = -1e9
    assert not made.services["distribute_wrench"](request).feasible
    request.pose.orientation.w = 0.0  # no attitude
    answer = made.services["distribute_wrench"](request)
    assert not answer.feasible
    assert answer.message


def test_at_its_end_it_waits_and_can_begin_again(node):
    made = node(rate=1.0)
    for _ in range(7):
        made.timer.tick()
    assert len(made.published["/clock"].sent) == 4  # of 4 s
    assert "the scenario ends" in made.said[-1]
    assert made.services["reset"](None).success
    made.timer.tick()
    assert made.published["/clock"].sent[-1].clock.sec == 0  # the last sample before 1 s
    assert len(made.published["/clock"].sent) == 5


def test_main_reports_errors(folder, monkeypatch, capsys):
    spun = []
    install(monkeypatch, NAME, folder / NAME, spun.append)
    for given, said in (
        ({"rate": 0.0}, "rate"),
        ({"scenario": "nowhere.yaml"}, "nowhere.yaml"),
        ({"backend": "x"}, "x"),
    ):
        monkeypatch.setattr(Node, "given", given)
        assert runpy.run_path(str(folder / NAME / NAME / "node.py"))["main"]() == 2
        assert said in capsys.readouterr().err
    monkeypatch.setattr(Node, "given", {})
    assert runpy.run_path(str(folder / NAME / NAME / "node.py"))["main"]() == 0
    assert spun[0].destroyed


def test_installed_files_exist(folder, monkeypatch):
    said = {}
    monkeypatch.setattr(setuptools, "setup", lambda **given: said.update(given))
    runpy.run_path(str(folder / NAME / "setup.py"))
    for _, files in said["data_files"]:
        for file in files:
            assert (folder / NAME / file).is_file()
    assert said["entry_points"]["console_scripts"] == [f"run = {NAME}.node:main"]
    install(monkeypatch, NAME, folder / NAME, None)
    launched = runpy.run_path(str(folder / NAME / "launch" / f"{NAME}.launch.py"))["generate_launch_description"]()
    assert launched[0]["executable"] == "run"
    assert (folder / NAME / "config/parameters.yaml").samefile(launched[0]["parameters"][0])
    parameters = yaml.safe_load((folder / NAME / "config/parameters.yaml").read_text())[NAME]["ros__parameters"]
    declared = set(re.findall(r'declare_parameter\("(\w+)"', (folder / NAME / NAME / "node.py").read_text()))
    assert set(parameters) == declared
    assert cdpr.load_scenario(folder / NAME / "config/scenario.yaml").robot.m == 8


def test_manifests_name_what_is_imported(folder):
    for package in (NAME, f"{NAME}_interfaces"):
        root = ElementTree.parse(folder / package / "package.xml").getroot()
        assert root.findtext("name") == package
    needs = {each.text for each in ElementTree.parse(folder / NAME / "package.xml").getroot().iter("exec_depend")}
    text = "".join(path.read_text() for path in (folder / NAME).rglob("*.py"))
    imported = {line.split()[1].split(".")[0] for line in text.splitlines() if re.match(r"(from|import) \w", line)}
    own = {"__future__", "cdpr", "math", "sys", "setuptools"}
    assert imported - own == needs
    service = (folder / f"{NAME}_interfaces/srv/DistributeWrench.srv").read_text()
    fields = [line.split()[1] for line in service.splitlines() if line and line[0] not in "#-"]
    assert fields == ["pose", "wrench", "feasible", "message", "tension", "residual"]


def test_nothing_is_overwritten_and_the_bytes_are_the_same(folder, tmp_path):
    scenario = cdpr.load_scenario(SCENARIO)
    with pytest.raises(OutputError, match="not empty"):
        write_ros2(scenario, folder)
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OutputError):
            write_ros2(scenario, place)
    (tmp_path / "two").mkdir()
    for path in write_ros2(scenario, tmp_path / "two")[0]:
        there = folder / path.relative_to(tmp_path / "two")
        assert path.read_bytes() == there.read_bytes()
        assert b"@PACKAGE@" not in path.read_bytes()
        assert str(ROOT).encode() not in path.read_bytes()


def test_a_controller_without_cpp_is_left_out_with_the_reason(tmp_path):
    scenario = cdpr.load_scenario(SCENARIO, overrides=["solver.type=exact"])
    files, omitted = write_ros2(scenario, tmp_path)
    assert len(omitted) == 1
    assert omitted[0].startswith("the controller as a C++ node: ")
    assert "solver 'exact'" in omitted[0]
    assert not any(f"{NAME}_control" in str(path) for path in files)
    assert exported(scenario, "ros2", {})[1] == omitted


def test_the_controller_is_made_once(monkeypatch):
    made = []
    monkeypatch.setattr(ros2, "native_files", lambda scenario: made.append(scenario) or native_files(scenario))
    _, omitted = packages(cdpr.load_scenario(SCENARIO))
    assert (len(made), omitted) == (1, [])


CASES = {
    "tensions": ("caroca", [], "effort"),
    "lengths": ("camera_robot", ["controller.flex_compensation=true"], "position"),
    "ideal drives": ("camera_robot", ["robot.winch={type: position}", "controller.type=computed_torque"], "position"),
    "rates": ("camera_robot", ["robot.winch.type=velocity", "controller.type=computed_torque"], "velocity"),
    "mixed": ("camera_robot", ["robot.cables[1].winch={type: torque, drum_radius: 0.05, inertia: 0.002}"], "mixed"),
}
MEASURED = ("ideal drives", "rates")  # whose controllers need measured unwound lengths


def compiled_node(package, place):
    """Compile the node of a package with stand-ins of rclcpp."""
    headers = place / "headers"
    for name in re.findall(r"#include <(\w+/.*hpp)>", (package / "src/node.cpp").read_text()):
        (headers / name).parent.mkdir(parents=True, exist_ok=True)
        (headers / name).write_text("#include <ros2_stand_ins.hpp>\n")
    includes = [f"-I{headers}", f"-I{ROOT / 'tests' / 'support'}"]
    sources = [str(package / "src" / name) for name in ("controller.cpp", "node.cpp")]
    flags = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-missing-field-initializers", "-ffp-contract=off"]
    subprocess.run([tool("g++"), *flags, *includes, *sources, "-o", "control"], cwd=place, check=True)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_cpp_node_reproduces_a_log_to_the_bit(case, tmp_path):
    """The node, compiled with stand-ins of rclcpp; without recent measurements it does not publish."""
    name, changes, field = CASES[case]
    scenario = cdpr.load_scenario(ROOT / "scenarios" / f"{name}.yaml", overrides=["simulation.duration=0.5", *changes])
    _, omitted = write_ros2(scenario, tmp_path)
    assert not [each for each in omitted if each.startswith("the controller")]
    (package,) = tmp_path.glob("*_control")
    compiled_node(package, tmp_path)
    run = cdpr.simulate(scenario)
    cables = list(run.header.cables)
    parts = ("position", "orientation", "velocity", "angular_velocity")
    np.hstack([run[each] for each in parts]).tofile(tmp_path / "states")
    files = {"SHARE": str(package), "STATES": "states", "COMMANDS": "commands", "UNWOUND": "unwound"}
    files["CABLES"] = " ".join(reversed(cables))
    if case in MEASURED:
        np.ascontiguousarray(run.unstretched_length[:, ::-1]).tofile(tmp_path / "unwound")
    done = subprocess.run(["./control"], cwd=tmp_path, env=os.environ | files, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    expected = run["tension" if case == "tensions" else "winch_command"]
    if field == "mixed":  # lengths, then tensions
        taken = [True, False, True, True]
        expected = np.hstack([np.where(taken, expected, np.nan), np.where(taken, np.nan, expected)])
    published = np.fromfile(tmp_path / "commands").reshape(expected.shape)
    np.testing.assert_array_equal(published, expected)
    assert [line.split() for line in done.stdout.splitlines()] == [cables] * len(expected)
    assert f"Field::{field.upper()}, " in (package / "src/node.cpp").read_text() or field == "mixed"
    assert done.stderr.count("status -1") == 2
    done = subprocess.run(
        ["./control"], cwd=tmp_path, env=os.environ | files | {"SHARE": "nowhere"}, capture_output=True
    )
    assert done.returncode == 2
    if case in MEASURED:  # lengths of other cables are not used
        files["CABLES"] = " ".join(f"other_{cable}" for cable in cables)
        done = subprocess.run(["./control"], cwd=tmp_path, env=os.environ | files, capture_output=True, text=True)
        assert (done.stdout, done.stderr.count("status -1")) == ("", 1)


ROBOT = """#pragma once
#include <stddef.h>
enum { CDPR_CABLES = 1, CDPR_STATE = 13, CDPR_DESIRED = 19, CDPR_FILE_BYTES = 8 };
enum { CDPR_OK, CDPR_REPLACED, CDPR_NO_ANSWER, CDPR_NOT_FINITE };
constexpr double CDPR_CONTROL_STEP = 0.5;
struct cdpr_robot {};
inline int answer = CDPR_OK, steps = 0;
inline double at = -1.0;
inline int cdpr_begin(cdpr_robot*, const void*, size_t) { return CDPR_OK; }
inline int cdpr_desired(cdpr_robot*, double time, double*) { at = time; return CDPR_OK; }
inline int cdpr_step(cdpr_robot*, double, const double*, const double*, double*) { steps++; return answer; }
"""
CYCLE = """#include "control.hpp"
int main(int, char** names) {
    Control control;
    const double pose[7] = {}, twist[6] = {};
    double tension[CDPR_CABLES];
    auto step = [&](double now, int next) {
        answer = next;
        const int status = control.step(now, 1.0, tension);
        printf("%d %d %g\\n", status, steps, at);
    };
    printf("%d %d\\n", control.load("nowhere"), control.load(names[0]));
    control.start();
    step(0.0, CDPR_OK);
    control.set_pose(0.0, pose);
    control.set_twist(0.0, twist);
    for (int next = 0; next <= CDPR_NOT_FINITE; next++) step(0.0, next);
    step(0.0, CDPR_OK);
    step(2.0, CDPR_OK);
    control.load(names[0]);
    step(0.0, CDPR_OK);
}
"""


def test_a_controller_that_is_not_finite_stops_until_it_is_loaded_again(folder, tmp_path):
    (tmp_path / "robot.h").write_text(ROBOT)
    (tmp_path / "cycle.cpp").write_text(CYCLE)
    shutil.copy(folder / f"{NAME}_control/src/control.hpp", tmp_path)
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([tool("g++"), *flags, "cycle.cpp", "-o", "cycle"], cwd=tmp_path, check=True)
    told = subprocess.run([tmp_path / "cycle"], check=True, capture_output=True, text=True).stdout.splitlines()
    before = ["-2 0", "-1 0 -1", "0 1 0", "1 2 0.5", "2 3 1", "3 4 1"]
    assert told == [*before, "3 4 1", "-1 4 1", "0 5 1"]


@pytest.mark.parametrize(
    ("robot", "package"),
    [("CoGiRo", "cdpr_cogiro"), ("a--b  c", "cdpr_a_b_c"), ("日本", "cdpr_robot"), ("3", "cdpr_3"), ("_x_", "cdpr_x")],
)
def test_names_are_those_that_ros_takes(robot, package):
    assert package_name(robot) == package
    assert re.fullmatch(r"[a-z][a-z0-9_]*", package)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gcode", "trajectory.file is the file 'outline.ngc'"),
        ("remote_controller", "controller.program is the file 'remote/law.py'"),
        ("remote_plant", "backend_options.remote.program is the file 'remote/plant.py'"),
    ],
)
def test_files_beside_the_scenario_are_refused(name, said):
    with pytest.raises(FormatError, match=said):
        packages(cdpr.load_scenario(ROOT / "scenarios" / f"{name}.yaml"))


def test_force_replaces_the_files_of_a_folder_and_keeps_others(tmp_path):
    files, _ = write_ros2(cdpr.load_scenario(SCENARIO), tmp_path)
    before = [file.read_bytes() for file in files]
    (tmp_path / "notes.txt").write_text("mine")
    files[0].write_text("changed")
    with pytest.raises(OutputError, match="is not empty: choose another name, or force=True"):
        cdpr.export(SCENARIO, "ros2", tmp_path)
    cdpr.export(SCENARIO, "ros2", tmp_path, force=True)
    assert [file.read_bytes() for file in files] == before
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_force_writes_through_no_link(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    files, _ = write_ros2(cdpr.load_scenario(SCENARIO), tmp_path / "out")
    package = next(file.parent for file in files if file.parent != tmp_path / "out")
    shutil.rmtree(package)
    package.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OutputError, match="is a symbolic link, and nothing is written through links"):
        write_ros2(cdpr.load_scenario(SCENARIO), tmp_path / "out", force=True)
    assert not list((tmp_path / "elsewhere").iterdir())


def test_of_two_exports_into_one_folder_only_the_first_writes(tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "iterdir", lambda _: iter(()))  # the other one begins after the check
    (tmp_path / "README.md").write_text("of another export")
    with pytest.raises(OutputError, match="exists already and is not empty"):
        cdpr.export(SCENARIO, "ros2", tmp_path)
    assert os.listdir(tmp_path) == ["README.md"]
    assert (tmp_path / "README.md").read_text() == "of another export"
