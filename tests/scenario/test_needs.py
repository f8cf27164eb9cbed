"""The needs table: every section declares its support, and every use consults the declarations."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT
from need_cases import FMU_OPTIONS, exports
from pydantic import Field, create_model

import cdpr
from cdpr.analysis.compare.job import compare_scenario
from cdpr.base.errors import PluginError, ScenarioError
from cdpr.base.fields import Section
from cdpr.base.needs import EVERYWHERE, UNDECLARED, USES, Needs, no
from cdpr.cables import MODELS
from cdpr.cables.chain import Chain
from cdpr.fmu.read.archive import open_archive
from cdpr.formats.write.export_model import begin, left_out
from cdpr.formats.write.ros2 import packages
from cdpr.link.peer import greeting_of
from cdpr.scenario import check
from cdpr.scenario.needs import declarations, in_use, part_declarations
from cdpr.scenario.schema import ScenarioSection
from cdpr.simulation.build import build
from cdpr.simulation.needs import omitted, require, supported
from cdpr.ui.cli import cli
from cdpr.ui.gui.session import SimulationSession
from cdpr.ui.live.drive import drive

SCENARIO = "robot: planar.yaml\nsimulation: {duration: 0.01}\n"
TOY = f"{SCENARIO}medium:\n  density: 1.2\n"


def missing(model):
    return [key for key, needs in declarations(model) if needs is None]


def schema_with(medium):
    """Return the schema of scenarios with the section `medium` of this class."""
    field = medium | None, Field(None, description="the air")
    return create_model("Toy", __base__=ScenarioSection, medium=field)


def medium_that_needs(needs=None):
    class Medium(Section):
        density: float = Field(description="mass per volume")

    if needs is not None:
        Medium.needs = needs
    return Medium


@pytest.fixture
def loaded(monkeypatch, tmp_path):
    """Return a function that loads a scenario with a section `medium` that has these needs."""

    def load(needs=None):
        monkeypatch.setattr(check, "ScenarioSection", schema_with(medium_that_needs(needs)))
        shutil.copy(ROOT / "scenarios" / "robots" / "planar.yaml", tmp_path)
        (tmp_path / "toy.yaml").write_text(TOY)
        return cdpr.load_scenario(tmp_path / "toy.yaml")

    return load


def test_each_key_and_part_declares_its_needs():
    assert missing(ScenarioSection) == []
    assert [name for name, needs in part_declarations() if needs is None] == []
    known = {key for key, _ in declarations(ScenarioSection)}
    assert {"believed", "events: wrench", "robot.cables.exit: pulley"} <= known


def test_a_section_without_declaration_is_found():
    assert missing(schema_with(medium_that_needs())) == ["medium.density"]
    assert missing(schema_with(medium_that_needs({"density": EVERYWHERE}))) == []
    assert missing(schema_with(medium_that_needs(EVERYWHERE))) == []


def test_a_key_without_declaration_is_found():
    class Toy(ScenarioSection):
        wind: float = Field(0.0, description="speed of the air")

    assert missing(Toy) == ["wind"]


def test_a_cable_part_without_declaration_is_found(monkeypatch):
    rigid = MODELS["rigid"]
    monkeypatch.setitem(MODELS, "rigid", Chain(replace(rigid.winch, needs=None), rigid.span))
    assert [name for name, needs in part_declarations() if needs is None] == ["robot.cable.model: rigid winch"]


def consumers(scenario, tmp_path):
    """Return a call of each use."""
    return {
        **exports(scenario, tmp_path),
        "rollout": lambda: cdpr.rollout(scenario, 1, vary={"controller.kp": [80.0]}),
        "batch": lambda: cdpr.Batch(scenario, 1),
        "live": lambda: drive(scenario, None),
        "window": lambda: SimulationSession(scenario, None),
        "compare": lambda: compare_scenario(scenario),
    }


def test_each_use_rejects_a_section_without_declaration(loaded, tmp_path):
    scenario = loaded()
    assert {*consumers(scenario, tmp_path), *FMU_OPTIONS, "threads"} >= set(USES)
    for use, call in consumers(scenario, tmp_path).items():
        with pytest.raises(ScenarioError, match=r"toy.yaml:4:\d+: medium.density: not supported by ") as told:
            call()
        assert "declares no `needs`; remove it from the file" in str(told.value), use
    assert not supported(scenario, "threads")


@pytest.mark.parametrize("use", USES)
def test_a_use_rejects_what_declares_that_it_does_not_support_it(loaded, use):
    scenario = loaded(Needs(**{use: no("there is no air")}))
    with pytest.raises(ScenarioError, match=rf"toy.yaml:4:\d+: medium: not supported by {USES[use]}: there is no air"):
        require(scenario, use)
    for other in set(USES) - {use}:
        require(scenario, other)


def test_the_command_rejects_it_by_name(loaded, tmp_path):
    loaded(Needs(plant_fmu=no("it has no air")))
    result = CliRunner().invoke(cli, ["fmu", "export", str(tmp_path / "toy.yaml"), "-o", str(tmp_path / "toy.fmu")])
    assert "medium: not supported by an exported FMU without controller: it has no air" in str(result.exception)
    assert not (tmp_path / "toy.fmu").exists()


@pytest.mark.parametrize("role", ["backend", "controller"])
def test_plugins_must_declare_required_features(loaded, role):
    scenario = loaded(Needs(**{role: {"features": "medium"}}))
    with pytest.raises(PluginError, match=rf"medium: {role} '\w+', .* does not support features: medium"):
        build(scenario)


def test_only_differences_from_defaults_count():
    scenario = cdpr.load_scenario("planar", overrides={"limits": "warn"})
    assert ("limits",) not in [path for path, _, _ in in_use(scenario)]
    scenario = cdpr.load_scenario("planar", overrides={"limits": "stop"})
    assert ("limits",) in [path for path, _, _ in in_use(scenario)]
    assert UNDECLARED not in [needs for _, needs, _ in in_use(scenario)]


def test_export_to_native_and_ros2_report_unchecked_limits_and_events():
    scenario = cdpr.load_scenario("cable_break", overrides={"limits": "stop"})
    lines = [
        "limits: an exported controller continues after limit violations",
        "events: only changes of the desired motion by events are exported (cable_break at 1 s)",
    ]
    assert omitted(scenario, "native") == lines
    assert packages(scenario)[1] == [f"of the controller as a C++ node: {line}" for line in lines]


def test_models_report_obstacles_gravity_and_velocities():
    changes = {
        "world.obstacles": [{"name": "post", "sphere": 0.1, "position": [0, 0, 9]}],
        "world.gravity": [0, 0, -1.6],
        "initial.velocity": [0.1, 0, 0],
    }
    subject = begin(cdpr.load_scenario("caroca", overrides=changes))
    assert left_out(subject, "mjcf") == ["world.obstacles: not exported (post)"]
    moving = "initial.velocity: the format has no initial velocity"
    assert left_out(subject, "sdf") == ["world.obstacles: not exported (post)", moving]
    still = "world.gravity: URDF has no gravity"
    assert left_out(subject, "urdf") == [still, "world.obstacles: not exported (post)", moving]


def test_a_plain_fmu_reports_events_and_winches(tmp_path):
    assert omitted(cdpr.load_scenario("cable_break"), "plant_fmu") == ["events: not exported (cable_break at 1 s)"]
    target = str(tmp_path / "winch.fmu")
    result = CliRunner().invoke(cli, ["fmu", "export", "winch", "-o", target, "--source-only"])
    assert result.exit_code == 0, result.output
    assert "its winches are not exported without --with-winch" in result.stderr


def test_remote_peers_receive_exits_and_pushing_legs():
    robot = cdpr.load_robot("cogiro_pulleys")
    greeting = greeting_of("plant", robot, np.array([0.0, 0.0, -9.81]))
    assert [each["type"] for each in greeting["exits"]] == ["pulley"] * robot.m
    assert greeting["unilateral"]


def test_an_fmu_of_a_robot_file_counts_the_steps_of_its_steppers(tmp_path):
    robot, fmu = ROOT / "scenarios" / "robots" / "v_plotter.yaml", tmp_path / "steps.fmu"
    words = ["fmu", "export", str(robot), "--out", str(fmu), "--source-only"]
    changes = ["winch.type=stepper", "winch.stall_torque=5.0"]
    done = CliRunner().invoke(cli, words + [word for each in changes for word in ("--set", each)])
    assert done.exit_code == 0, done.output
    assert {"lost_steps", "counted_length"} <= set(open_archive(fmu).description.by_name)


def test_exported_fmus_report_brakes(tmp_path):
    said = "left out: robot.winch.brake_torque: exported winches always have power"
    scenario = cdpr.load_scenario("winch", overrides={"robot.winch.brake_torque": 5.0})
    for use, count in (("plant_fmu", 1), ("controller_fmu", 1), ("native", 0)):
        assert sum(line.startswith("robot.winch.brake_torque") for line in omitted(scenario, use)) == count
    words = ["fmu", "export", "caroca_winches", "--with-winch", "--set", "winch.brake_torque=5", "--source-only"]
    done = CliRunner().invoke(cli, [*words, "--out", str(tmp_path / "plant.fmu")])
    assert not done.exit_code, done.output
    assert said in done.stderr


def test_a_controller_alone_is_exported_without_the_drives(tmp_path):
    words = ["fmu", "export", "caroca", "--set", "drives.delay=0.004", "--source-only", "--out"]
    done = CliRunner().invoke(cli, [*words, str(tmp_path / "alone.fmu"), "--controller"])
    assert not done.exit_code, done.output
    done = CliRunner().invoke(cli, [*words, str(tmp_path / "both.fmu"), "--with-controller"])
    assert "drives: not supported by an exported FMU with controller" in str(done.exception)
