"""Files that are read, and messages about the others."""

from __future__ import annotations

import errno
import os
import tracemalloc

import pytest
from scenario_cases import BASE, HEAD, PLUGINS, QUINTIC, ROBOT, TAIL

from cdpr.base.errors import ScenarioError
from cdpr.model import Robot
from cdpr.scenario import Scenario, load_any, load_robot, load_scenario

pytestmark = pytest.mark.core


def refusal(path, load=load_scenario, **arguments) -> str:
    with pytest.raises(ScenarioError) as caught:
        load(path, **arguments)
    (only,) = caught.value.problems
    return only


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "tripod.yaml").write_text(ROBOT)
    (tmp_path / "a.yaml").write_text(HEAD + "robot: robots/tripod.yaml\n" + QUINTIC + TAIL)
    return tmp_path


def with_robot(folder, name: str) -> str:
    return refusal(folder / "a.yaml", text=HEAD + f"robot: {name}\n" + QUINTIC + TAIL, plugins=PLUGINS)


def test_a_robot_file_is_found_from_the_scenario_not_from_here(folder, monkeypatch):
    monkeypatch.chdir("/")
    assert load_scenario(folder / "a.yaml", plugins=PLUGINS).robot.m == 3
    monkeypatch.chdir(folder / "robots")
    assert load_scenario("../a.yaml", plugins=PLUGINS).robot.name == "tripod"


def test_a_text_replaces_a_robot_file(folder, monkeypatch):
    heavier = {str(folder / "robots" / "tripod.yaml"): ROBOT.replace("mass: ", "mass: 1", 1)}
    expected = load_robot("tripod.yaml", text=ROBOT.replace("mass: ", "mass: 1", 1)).platform.mass
    monkeypatch.chdir(folder / "robots")
    scenario = load_scenario("../a.yaml", files=heavier, plugins=PLUGINS)
    assert scenario.robot.platform.mass == expected
    assert scenario.with_changes({"simulation.duration": 1.0}).robot.platform.mass == expected
    assert load_scenario("../a.yaml", plugins=PLUGINS).robot.platform.mass != expected
    missing = {str(folder / "robots" / "other.yaml"): ROBOT}
    text = HEAD + "robot: robots/other.yaml\n" + QUINTIC + TAIL
    assert load_scenario("../a.yaml", text=text, files=missing, plugins=PLUGINS).robot.m == 3


def test_a_robot_file_may_lie_beside_the_folder(folder):
    (folder / "runs").mkdir()
    text = HEAD + "robot: ../robots/tripod.yaml\n" + QUINTIC + TAIL
    assert load_scenario(folder / "runs" / "a.yaml", text=text, plugins=PLUGINS).robot.m == 3


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("robots/tripot.yaml", "tripot.yaml': did you mean 'tripod.yaml'?"),
        ("robots/tripod", "did you mean 'tripod.yaml'?"),
        ("robots/quite_other.yaml", "; files there: tripod.yaml"),
        ("robot/tripod.yaml", "there is no folder '"),
        ("robots", "is a folder"),
        (".", "is a folder"),
        ("/etc/passwd", "expected a file name relative to this file, got the absolute '/etc/passwd'"),
        ("/dev/zero", "got the absolute"),
        ("../../../../../../../../dev/zero", "is not a regular file"),
        ("../../../../../../../../dev/null", "is not a regular file"),
        ('"a\\0b.yaml"', "cannot read"),
        ("x" * 5000, "cannot read"),
        ('""', "a file name or a mapping of name, dof"),
        (
            "5",
            "a file name or a mapping of name, dof, unilateral, platform, tension, frame, home, cable, winch, "
            "cables, got 5",
        ),
        ("[a.yaml]", "got a list of 1"),
        ("a.yaml", "is a scenario; expected a robot file"),
    ],
)
def test_robot_files_that_are_none(folder, name, what):
    line = with_robot(folder, name)
    assert what in line
    if name != '""':
        assert line.startswith(f"{folder}/a.yaml:9:8: robot: ")


def test_a_fifo_is_refused_without_waiting_for_it(folder):
    os.mkfifo(folder / "robots" / "pipe.yaml")
    assert "is not a regular file" in with_robot(folder, "robots/pipe.yaml")  # no writer: it would wait for ever
    assert "is not a regular file" in refusal(folder / "robots" / "pipe.yaml")


def test_a_link_to_a_device_is_refused_and_one_to_a_file_is_not(folder):
    (folder / "robots" / "zero.yaml").symlink_to("/dev/zero")
    (folder / "robots" / "link.yaml").symlink_to("tripod.yaml")
    assert "is not a regular file" in with_robot(folder, "robots/zero.yaml")
    text = HEAD + "robot: robots/link.yaml\n" + QUINTIC + TAIL
    assert load_scenario(folder / "a.yaml", text=text, plugins=PLUGINS).robot.m == 3


def test_a_file_without_permission(folder, monkeypatch):
    """Root may read everything, so that it is the system call that must refuse."""
    path, opened = str(folder / "robots" / "tripod.yaml"), os.open

    def refuse(name, *arguments, **more):
        if os.fspath(name) == path:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        return opened(name, *arguments, **more)

    monkeypatch.setattr(os, "open", refuse)
    assert "Permission denied" in with_robot(folder, "robots/tripod.yaml")


def test_a_large_file_is_not_read_to_its_end(folder):
    large = folder / "large.yaml"
    with large.open("wb") as file:
        file.truncate(10**10)  # sparse: no byte of it is written
    tracemalloc.start()
    try:
        assert refusal(large).startswith(f"{large}:1:1: larger than 256 KiB")
        assert tracemalloc.get_traced_memory()[1] < 2**22  # bytes at most: many times the limit, a small part of it all
    finally:
        tracemalloc.stop()


def test_yaml_problems_are_reported_in_the_robot_file(folder):
    (folder / "robots" / "tripod.yaml").write_text("name: [\n")
    line = refusal(folder / "a.yaml", plugins=PLUGINS)
    assert line.startswith(f"{folder}/robots/tripod.yaml:2:1: robot: not valid YAML")


def test_a_duplicate_key_of_a_robot_file_is_reported_with_the_rest(folder):
    (folder / "robots" / "tripod.yaml").write_text(ROBOT + "name: again\nwheels: 4\n")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(folder / "a.yaml", plugins=PLUGINS)
    twice, wheels = caught.value.problems
    assert "tripod.yaml:22:1: robot.name: given twice; the first is in line 1" in twice
    assert "tripod.yaml:23:1: robot.wheels: unknown key 'wheels'" in wheels


def test_a_missing_scenario_names_its_neighbour(folder):
    (folder / "caroca.yaml").write_text(BASE)
    assert refusal(folder / "carocca.yaml").endswith("carocca.yaml': did you mean 'caroca.yaml'?")
    assert "is a folder" in refusal(folder)


def test_files_of_the_other_kind(folder):
    assert refusal(folder / "robots" / "tripod.yaml").endswith(
        "this is a robot file; use it in a scenario by 'robot: FILE': 'cdpr new scenario --robot FILE' writes one"
    )
    assert refusal(folder / "a.yaml", load_robot).endswith("this is a scenario file; expected a robot file")


def test_any_kind(folder):
    assert isinstance(load_any(folder / "a.yaml", plugins=PLUGINS), Scenario)
    assert isinstance(load_any(folder / "robots" / "tripod.yaml"), Robot)


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("tripod.yaml", "tripod"),
        ("my robot (2).yaml", "my_robot_2_"),
        (".hidden.yaml", "hidden"),
        ("v1.2.yaml", "v1.2"),
        ("---.yaml", "unnamed"),
        ("x" * 100 + ".yaml", "x" * 64),
    ],
)
def test_names_come_from_files(file, name):
    assert load_robot(f"some/{file}", text=ROBOT.replace("name: tripod\n", "")).name == name
    text = BASE.replace("name: every-key\n", "")
    assert load_scenario(f"some/{file}", text=text, plugins=PLUGINS).name == name
