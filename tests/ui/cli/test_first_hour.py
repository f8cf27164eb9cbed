"""`cdpr new` writes files that run; `cdpr doctor` reports the installation."""

from __future__ import annotations

import json
import re
import shlex
import sys
from dataclasses import replace

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from command_line import cdpr_here
from conftest import ROOT
from spread import sampled

import cdpr
from cdpr.base.errors import ExitCode
from cdpr.cables import commands_of
from cdpr.native import library as native
from cdpr.native.operations import target
from cdpr.plugins.registry import OWN_DISTRIBUTION, registry
from cdpr.scenario import load_any, load_robot, load_scenario
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.template import RESTS
from cdpr.tension.closure import positive_null_vector
from cdpr.ui.cli import cli, health

ROBOTS = sorted((ROOT / "scenarios" / "robots").glob("*.yaml"))
SIZES = [
    "",
    "--straight",
    "--frame 4,4,4 --platform 0.4,0.4,0.4",
    "--frame 0.2,0.2,0.2 --platform 0.02,0.02,0.02 --mass 0.05",
    "--frame 300,300,100 --platform 10,10,5 --mass 30000",
    "--planar",
    "--planar --straight --frame 4,1,3 --platform 0.4,0.1,0.2",
    "--cables 3",
    "--cables 4",
    "--cables 6",
    "--suspended",
    "--suspended --straight",
    "--cables 7 --frame 3,2.5,2 --platform 0.3,0.25,0.2 --mass 8",
]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words, code=0):
    done = CliRunner().invoke(cli, [*words])
    if done.exception and not isinstance(done.exception, SystemExit):
        assert code == ExitCode.BAD_INPUT or getattr(done.exception, "exit_code", 0) == code, done.exception
        return str(done.exception)
    assert done.exit_code == code, done.output
    return done.stdout


@sampled(3, "sizes", SIZES)
def test_a_new_robot_holds_its_weight_and_passes_all_checks(here, sizes):
    run("new", "robot", "a-robot.yaml", *shlex.split(sizes))
    warnings = []
    robot = load_any("a-robot.yaml", warnings=warnings)
    assert warnings == []
    assert robot.name == "a-robot"
    assert cdpr.distribute(robot, robot.home[None]).feasible.all()
    if robot.m > robot.n and "--cables" not in sizes and "--suspended" not in sizes:  # those hang
        rows = wrench_rows(robot)
        assert np.linalg.matrix_rank(rows) == robot.n
        assert positive_null_vector(rows) is not None


def wrench_rows(robot):
    """W of the free directions at home, upright, from its definition."""
    chords = robot.anchors[:, :3] - robot.home[:3] - robot.anchors[:, 3:]
    units = chords / np.linalg.norm(chords, axis=1)[:, None]
    return np.hstack([units, np.cross(robot.anchors[:, 3:], units)]).T[robot.rows]


@sampled(1, "sizes", ["", "--planar --straight --frame 4,1,3 --platform 0.4,0.1,0.2", "--cables 4"])
def test_a_new_scenario_runs_as_it_is(here, sizes):
    run("new", "scenario", *shlex.split(sizes))
    finished = cdpr.simulate("scenario.yaml", overrides={"simulation.control_step": 0.01})
    figures = finished.summary()
    assert figures["status"] == "finished"
    assert figures["infeasible_steps"] == 0
    assert figures["position_error_m"]["max"] < 0.01
    assert np.linalg.norm(finished.position[-1] - finished.position[0]) > 0.05


@sampled(lambda path: path.stem in ("caroca", "planar", "seven"), "path", ROBOTS, ids=lambda path: path.stem)
def test_a_new_scenario_for_any_robot(here, path):
    run("new", "scenario", "sub.yaml", "--robot", str(path))
    scenario = load_scenario("sub.yaml")
    assert scenario.robot.name == path.stem
    assert scenario.warnings == ()
    moves = scenario.robot.m >= scenario.robot.n  # fewer cables do not control all degrees of freedom
    assert ("trajectory" in yaml.safe_load((here / "sub.yaml").read_text())) == moves


@pytest.mark.slow
@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_a_new_scenario_for_any_robot_runs(here, path):
    run("new", "scenario", "sub.yaml", "--robot", str(path))
    figures = cdpr.simulate("sub.yaml").summary()
    assert (figures["status"], figures["infeasible_steps"]) == ("finished", 0)
    assert not any(figures.get("beyond_limits_steps", {}).values())


@pytest.mark.parametrize("name", [pytest.param("cogiro_servos", marks=pytest.mark.slow), "v_plotter"])
def test_a_new_scenario_for_position_servos_commands_lengths(here, name):
    """Wrenches through servos that lag leave the limits of the tensions."""
    run("new", "scenario", "sub.yaml", "--robot", name)
    scenario = load_scenario("sub.yaml")
    assert commands_of(scenario.robot) == ["length"] * scenario.robot.m
    assert scenario.controller.type == "inverse_kinematics"
    assert scenario.controller_options.flex_compensation
    overrides = {"trajectory": {"type": "hold"}, "simulation.duration": 0.1}
    held = cdpr.simulate("sub.yaml", overrides=overrides)
    assert held.summary()["position_error_m"]["max"] < 1e-6  # m: the accuracy of resting poses in the issue


def test_every_key_has_a_comment_from_the_schema(here):
    run("new", "robot")
    run("new", "scenario", "--robot", "robot.yaml")
    for name in ("robot.yaml", "scenario.yaml"):
        lines = (here / name).read_text().splitlines()
        keys = [(i, line) for i, line in enumerate(lines) if re.match(r" *[a-z_]+:", line)]
        assert len(keys) > 10
        assert [line for i, line in keys if "# " not in line and not lines[i - 1].lstrip().startswith("#")] == []
    text = re.sub(r"\n *# *", " ", (here / "robot.yaml").read_text())
    for field in ("platform", "tension", "home"):
        assert RobotSection.model_fields[field].description in text
    assert "mass of the platform [kg]" in text
    assert "proportional gain, one number or six: x, y, z, rx, ry, rz [1/s^2]" in (here / "scenario.yaml").read_text()
    assert max(map(len, text.splitlines())) < 2000
    assert all(len(line) <= 120 for line in (here / "robot.yaml").read_text().splitlines())


def test_the_new_scenario_names_its_robot_from_where_it_lies(here):
    (here / "deep").mkdir()
    run("new", "robot", "mine.yaml")
    run("new", "scenario", "deep/one.yaml", "--robot", "mine.yaml")
    assert load_scenario("deep/one.yaml").robot.name == "mine"
    run("new", "scenario", "two.yaml", "--robot", "cogiro")  # an example
    assert load_scenario("two.yaml").robot.name == "cogiro"


@pytest.mark.slow
def test_a_scenario_beyond_a_link_names_its_robot(here):
    """`..` leads upwards from where the link leads."""
    (here / "far" / "away").mkdir(parents=True)
    (here / "link").symlink_to("far/away")
    run("new", "robot", "mine.yaml")
    run("new", "scenario", "link/one.yaml", "--robot", "mine.yaml")
    assert load_scenario("link/one.yaml").robot.name == "mine"
    (here / "other.yaml").symlink_to("mine.yaml")  # the link's own name stays
    run("new", "scenario", "link/two.yaml", "--robot", "other.yaml")
    assert yaml.safe_load((here / "link" / "two.yaml").read_text())["robot"] == "../../other.yaml"


def test_a_scenario_of_a_tiny_robot_moves_a_tenth_of_it(here):
    run("new", "scenario", "s.yaml", *["--cables", "3", "--frame", "1e-3,1e-3,1e-3", "--platform", "1e-4,1e-4,1e-4"])
    scenario = load_scenario("s.yaml")
    assert scenario.trajectory.to.position == (1e-4, 1e-4, 5e-4)  # hangs from anchors of one height


@pytest.mark.slow
def test_printed_names_can_be_typed(here):
    assert "next: cdpr info 'a b.yaml'" in CliRunner().invoke(cli, ["new", "robot", "a b.yaml"]).stderr


def test_existing_files_are_kept(here):
    run("new", "robot")
    before = (here / "robot.yaml").read_text()
    assert "already exists and is not overwritten" in run("new", "robot", "--planar", code=ExitCode.NOT_WRITABLE)
    assert (here / "robot.yaml").read_text() == before
    assert "there is no folder 'no/such'" in run("new", "robot", "no/such/folder.yaml", code=ExitCode.NOT_WRITABLE)
    assert load_robot("-", text=run("new", "robot", "-")).m == 8
    assert [path.name for path in here.iterdir()] == ["robot.yaml"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--frame 4,3", "three lengths (m)"),
        ("--frame a,b,c", "three lengths (m)"),
        ("--mass -1", "mass: expected 1e-09 to 1e+06 kg, got -1 kg"),
        ("--mass nan", "got nan kg"),
        ("--mass 1e300", "got 1e+300 kg"),
        (
            "--frame 1e9,1e9,1e9",
            "expected 0.0001 to 2000 m, got 1e+09 m; lengths are in metres",
        ),
        ("--frame 1e-6,1e-6,1e-6 --platform 1e-7,1e-7,1e-7", "got 1e-06 m"),
        ("--frame inf,1,1", "got inf m"),
        ("--cables 0", "got 0"),
        ("--planar --cables 0", "got 0"),
        ("--platform 5,0.3,0.2", "must be smaller than the frame"),
        (
            "--cables 5",
            "8 or 7 cables hold a platform from all sides; suspended (--suspended), 8 or 6 move it",
        ),
        ("--cables 7 --suspended", "got 7 suspended"),
        ("--planar --suspended", "a planar robot has 4 cables, one at each corner, got 4 suspended"),
        ("--planar --cables 8", "a planar robot has 4 cables"),
        ("--planar --straight --frame 4,1,4 --platform 0.4,0.1,0.4", "try crossed cables (--crossed)"),
    ],
)
def test_sizes_that_cannot_be(here, words, told):
    done = cdpr_here("new", "robot", *shlex.split(words), cwd=here, code=2)
    assert told in done.stderr
    assert not list(here.iterdir())


@pytest.mark.slow
def test_sizes_as_if_in_millimetres_are_reported(here):
    done = cdpr_here("new", "robot", *shlex.split("--frame 2000,1500,1250 --platform 200,150,100"), cwd=here)
    assert "lighter than air; lengths are in metres" in done.stderr
    assert "warning" not in cdpr_here("new", "robot", "good.yaml", cwd=here).stderr


def test_sizes_are_those_of_the_robot_that_is_named(here):
    assert "--mass" in run("new", "scenario", "--robot", "caroca", "--mass", "3", code=ExitCode.BAD_INPUT)
    assert "there is no file" in run("new", "scenario", "--robot", "nowhere.yaml", code=ExitCode.BAD_INPUT)


def test_a_scenario_without_a_move_is_reported(here):
    """Four cables hold the weight of a box at home, and nothing against pushes."""
    run("new", "robot", "r.yaml", "--straight", "--frame", "4,3,2.5", "--platform", "0.4,0.3,0.2")
    text = (here / "r.yaml").read_text()
    lower = text.index("- {frame: [-2.0, -1.5, 0.0]")  # the first of the lower cables
    home = "home:\n  position: [0.0, 0.0, 1.0]\n"
    (here / "four.yaml").write_text(text[:lower] + ("" if "\nhome:" in text[:lower] else home))
    done = CliRunner().invoke(cli, ["new", "scenario", "s.yaml", "--robot", "four.yaml"])
    assert done.exit_code == 0
    assert f"{RESTS} 'cdpr info s.yaml' shows details" in done.stderr
    told = (here / "s.yaml").read_text()
    assert told.startswith(f"# {RESTS}")
    assert "trajectory" not in told
    run("new", "scenario", "moves.yaml", "--robot", "r.yaml")
    assert (here / "moves.yaml").read_text().startswith("# A slow move from home")


@pytest.fixture(scope="module")
def examined():
    return list(health.examine())


def test_the_doctor_looks_at_all(examined):
    assert [one for one in examined if one.state == "wrong"] == []
    names = {(one.group, one.name): one for one in examined}
    assert names["versions", "cdpr"].text.startswith(cdpr.__version__)
    assert names["libraries", "numpy"].text == np.__version__
    assert all(one.remedy for one in examined if one.state == "missing" and one.group != "tools")
    assert {name for group, name in names if group == "folders"} == {"temporary", "home", "here"}
    library = names["kernels", "library"].text
    assert native.__file__ in library
    assert f"built by {native.compiler}" in library
    assert names["kernels", "instruction set"].text.startswith(f"{target()}; also available: ")
    found = registry()
    for role, rows in found.plugins.items():
        assert {one.name for one in examined if one.group == f"{role}s"} == set(rows)


def test_the_doctor_reports_an_instruction_set_that_this_processor_lacks(monkeypatch):
    monkeypatch.setenv("CDPR_NATIVE_TARGET", "x86-64-v9")
    (wrong,) = [one for one in health.kernels() if one.state == "wrong"]
    assert "got 'x86-64-v9'" in wrong.text
    assert wrong.remedy == "correct or unset CDPR_NATIVE_TARGET"


def test_the_doctor_reports_a_library_that_is_not_built(monkeypatch):
    monkeypatch.setitem(sys.modules, "cdpr.native.library", None)
    monkeypatch.delattr("cdpr.native.library", raising=False)
    (wrong,) = health.kernels()
    assert wrong.state == "wrong"
    assert "pip install --editable ." in wrong.remedy


def test_the_doctor_reports_a_library_of_other_sources(monkeypatch):
    monkeypatch.setattr(native, "sources", "0")
    (wrong,) = [one for one in health.kernels() if one.state == "wrong"]
    assert "built from other C++ sources" in wrong.text
    assert "pip install --no-deps --editable ." in wrong.remedy


def test_the_doctor_on_the_command_line(here):
    done = cdpr_here("doctor", cwd=here)
    assert done.stdout.splitlines()[-1] == "all that is installed works"
    assert re.search(r"^  numpy +\d", done.stdout, re.MULTILINE)
    told = json.loads(cdpr_here("doctor", "--json", cwd=here).stdout)
    assert told["ok"] is True
    assert set(told["found"][0]) == {"group", "name", "state", "text", "remedy"}


def test_the_doctor_reports_missing_packages_with_a_remedy(monkeypatch):
    """As if nothing but cdpr were there."""
    version = health.importlib.metadata.version

    def without(name):
        if name in ("mujoco", "osqp"):
            raise health.importlib.metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(health.importlib.metadata, "version", without)
    missing = {one.name: one for one in health.libraries() if one.state != "ok"}
    assert missing["mujoco (mujoco)"].remedy == "pip install 'cdpr[mujoco]'"
    assert missing["osqp (solvers)"].remedy == "pip install 'cdpr[solvers]'"
    assert {one.state for one in missing.values()} == {"missing"}
    monkeypatch.setattr(health, "compiler", lambda: (_ for _ in ()).throw(cdpr.PluginError("none")))
    monkeypatch.setattr(health.shutil, "which", lambda name: None)
    tools = {one.name: one for one in health.tools()}
    assert tools["C++ compiler"].state == tools["browser"].state == "missing"


def test_the_doctor_reports_broken_packages(monkeypatch, here):
    found = registry()
    entry = found.plugins["solver"]["qp"]
    spoilt = replace(entry, info=replace(entry.info, factory="there_is_no_such_module:Solver"))
    monkeypatch.setitem(found.plugins["solver"], "qp", spoilt)
    (wrong,) = [one for one in health.plugins() if one.state == "wrong"]
    assert (wrong.group, wrong.name) == ("solvers", "qp")
    assert "No module named 'there_is_no_such_module'" in wrong.text
    assert OWN_DISTRIBUTION in wrong.text
    assert run("doctor", code=ExitCode.PLUGIN).splitlines()[-1] == "1 do not work"


def test_the_doctor_reports_unwritable_folders(monkeypatch, here):
    monkeypatch.setenv("HOME", str(here / "nowhere"))
    wrong = {one.name: one for one in health.folders() if one.state == "wrong"}
    assert set(wrong) == {"home"}
    assert "cannot be written" in wrong["home"].text
    assert run("doctor", code=ExitCode.NOT_WRITABLE).splitlines()[-1] == "1 do not work"


def test_the_doctor_in_a_folder_that_is_gone(monkeypatch, here):
    (here / "gone").mkdir()
    monkeypatch.chdir(here / "gone")
    (here / "gone").rmdir()
    assert {one.name: one for one in health.folders()}["here"].state == "wrong"


@pytest.mark.parametrize(("command", "state"), [("cc 'x", "missing"), ("no-such-cc", "missing"), ("''", "missing")])
def test_the_doctor_and_a_compiler_that_is_none(monkeypatch, command, state):
    monkeypatch.setenv("CXX", command)
    assert {one.name: one for one in health.tools()}["C++ compiler"].state == state
