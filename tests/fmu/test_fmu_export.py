"""`cdpr fmu export`: the file, its description, its bytes, and its error messages."""

from __future__ import annotations

import json
import sys
import warnings
import zipfile
from pathlib import Path
from typing import NamedTuple

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from fmpy.validation import validate_fmu
from fmu.cases import FMI, plant_of, quick_compiler, scenario, write
from fmu.driver import Driver
from spread import spread

from cdpr.fmu.export import archive, cached_fmu, fmu_bytes
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.mapping import map_signals
from cdpr.ui.cli import main

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
ROBOT = str(ROOT / "scenarios" / "robots" / "caroca.yaml")
WINCHES = str(ROOT / "scenarios" / "robots" / "caroca_winches.yaml")


class Done(NamedTuple):
    stdout: str
    stderr: str


@pytest.fixture
def cdpr(tmp_path, monkeypatch, capfd):
    """Run `cdpr fmu ...` in a folder of its own, with a list of trusted FMUs of its own."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.chdir(tmp_path)

    def run(*arguments, code=0, **env):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["cdpr", "fmu", *arguments])
            patch.setattr(warnings, "showwarning", warnings.showwarning)
            for name, value in env.items():
                patch.setenv(name, value)
            with pytest.raises(SystemExit) as exit_:
                main()
        done = Done(*capfd.readouterr())
        assert exit_.value.code == code, done
        return done

    return run


def entries(path):
    with zipfile.ZipFile(path) as opened:
        return {info.filename: opened.read(info) for info in opened.infolist()}


@spread("case, fmi", ["planar", "caroca", "cogiro_elastic", "cogiro_rigid"], [2, 3])
@pytest.mark.usual("cogiro_rigid-3", "planar-2")
def test_the_fmi_checker_reports_no_errors(case, fmi, tmp_path):
    path = write(plant_of(scenario(case)), fmi, tmp_path)
    assert validate_fmu(str(path)) == []
    about = fmpy.read_model_description(str(path))
    assert about.coSimulation.canSerializeFMUstate
    compiled = sorted(Path(name).name for name in entries(path) if name.endswith(".cpp"))
    if fmi == 2:  # whose sources are C
        assert not [name for name in entries(path) if name.startswith("sources/")]
    else:
        assert sorted(about.buildConfigurations[0].sourceFileSets[0].sourceFiles) == compiled
        assert "sources/cdpr_backends/reference.hpp" in entries(path)
    assert ("sources/buildDescription.xml" in entries(path)) == (fmi == 3)  # that file is of FMI 3
    for variable in about.modelVariables:
        assert variable.description
        assert variable.unit or "quaternion" in variable.name


@FMI
@pytest.mark.parametrize("case", ["caroca", "planar", "cogiro_elastic", "cogiro_rigid"])
def test_its_signals_map_by_themselves(case, fmi, tmp_path):
    loaded = scenario(case)
    opened = open_archive(write(plant_of(loaded), fmi, tmp_path))
    mapping = map_signals(opened.description, loaded.robot)
    pull = "cable_tension" if loaded.robot.cable_model == "ideal" else "command"
    assert list(mapping.inputs.ports) == [pull, "external_wrench"]
    expected = ["position", "quaternion", "velocity", "angular_velocity", "cable_length", "cable_rate"]
    assert list(mapping.outputs.ports)[:6] == expected


def test_only_rigid_winches_pass_inputs_through(tmp_path):
    for case, direct in [("caroca", set()), ("cogiro_elastic", set()), ("cogiro_rigid", {"cable_tension"})]:
        about = fmpy.read_model_description(str(write(plant_of(scenario(case)), 3, tmp_path)))
        assert {unknown.variable.name for unknown in about.outputs if unknown.dependencies is None} == direct


@pytest.mark.slow
def test_the_same_robot_makes_the_same_bytes(tmp_path, monkeypatch):
    """Compiled twice, in different folders."""
    monkeypatch.setenv("CXX", quick_compiler(tmp_path))
    made = []
    for name in ("one", "another place"):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / name))
        made.append([fmu_bytes(plant_of(scenario("caroca")), fmi) for fmi in (2, 3)])
    assert made[0] == made[1]


def test_another_plant_has_another_token(tmp_path):
    tokens = set()
    for fmi in (2, 3):
        for step in (0.001, 0.002):
            path = write(plant_of(scenario("caroca"), step), fmi, tmp_path)
            tokens.add(open_archive(path).description.token)
    assert len(tokens) == 2


@pytest.mark.slow
def test_it_is_compiled_once(tmp_path, monkeypatch):
    """Then it comes from the cache, as long as source and compiler are the same."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    log = tmp_path / "calls"
    monkeypatch.setenv("CXX", quick_compiler(tmp_path, f"echo called >> {log}"))
    plant = plant_of(scenario("caroca"))
    first = cached_fmu(plant)
    calls = log.read_text()
    assert cached_fmu(plant) == first == cached_fmu(plant_of(scenario("caroca")), 3)
    assert first.stem == open_archive(first).sha256
    assert cached_fmu(plant, 2) != first
    assert log.read_text() == calls != ""
    first.write_bytes(b"damaged")
    with pytest.warns(UserWarning, match="is damaged: it is replaced by a new one"):
        assert cached_fmu(plant) == first
    assert first.stem == open_archive(first).sha256


@FMI
@pytest.mark.parametrize("name", ["with space", "mit ä und %20", "日本"])
@pytest.mark.usual("*-3")
def test_it_works_wherever_it_lies(fmi, name, tmp_path):
    """FMI 2 gives the folder as a percent-encoded URI, FMI 3 as a path."""
    plant = plant_of(scenario("caroca"))
    with Driver(write(plant, fmi, tmp_path), folder=tmp_path / name) as driver:
        assert (driver.state() == plant.state).all()


@FMI
def test_the_command_takes_state_gravity_and_step_of_a_scenario(fmi, tmp_path, cdpr):
    changes = ["world.gravity=[0,0,-1.6]", "simulation.physics_step=0.0005", "initial.velocity=[0.1,0,0]"]
    options = [word for change in changes for word in ("--set", change)]
    told = json.loads(cdpr("export", CAROCA, "-o", "out/a.fmu", "--fmi", str(fmi), "--json", *options).stdout)
    opened = open_archive(tmp_path / "out" / "a.fmu")
    assert told["sha256"] == opened.sha256
    assert told["fmi"] == fmi
    assert opened.sha256 in cdpr("trust").stdout  # what one made oneself
    with Driver(opened.path) as driver:
        assert driver.state().tolist() == [0, 0, 1.2, 1, 0, 0, 0, 0.1, 0, 0, 0, 0, 0]
        assert driver.get("gravity").tolist() == [0, 0, -1.6]
        assert driver.get("physics_step") == 0.0005


def test_a_robot_starts_at_home(tmp_path, cdpr):
    said = cdpr("export", ROBOT, "-o", "a.fmu", "--step", "0.002", "--set", "platform.mass=99").stdout
    assert said.startswith("a.fmu: FMI 3, caroca, 8 cables, ")
    with Driver(tmp_path / "a.fmu") as driver:
        assert driver.get("position").tolist() == [0, 0, 1.2]
        assert driver.get("mass") == 99
        assert driver.get("physics_step") == 0.002


@pytest.mark.slow
def test_winches_are_exported_on_request(tmp_path, cdpr):
    cdpr("export", WINCHES, "-o", "a.fmu", "--with-winch")
    with Driver(tmp_path / "a.fmu") as driver:
        driver.set("command", np.full(8, 300.0))
        assert np.allclose(driver.get("cable_tension"), 300.0)  # winches begin as commanded
    cdpr("export", WINCHES, "-o", "b.fmu")
    with Driver(tmp_path / "b.fmu") as driver:
        driver.set("cable_tension", np.full(8, 300.0))
    cdpr("export", WINCHES, "-o", "w.fmu", "--only-winch")
    with Driver(tmp_path / "w.fmu") as driver:
        assert (driver.get("cable_length") > 1.0).all()  # those at home
        driver.set("command", np.full(8, 300.0))
        assert np.allclose(driver.get("cable_tension"), 300.0)
    assert "exclude each other" in cdpr("export", WINCHES, "-o", "c.fmu", "--only-winch", "--with-winch", code=2).stderr
    stretching = ("--set", "cable.model=elastic", "--set", "cable.axial_stiffness=1e5")
    assert "winch" in cdpr("export", ROBOT, "-o", "c.fmu", "--only-winch", *stretching, code=2).stderr
    said = cdpr("export", ROBOT, "-o", "c.fmu", "--with-winch", code=2).stderr
    assert "ideal cables" in said
    assert "cable.model rigid or elastic" in said
    assert not (tmp_path / "c.fmu").exists()


@pytest.mark.slow
@FMI
def test_winches_alone_are_those_of_the_robot(fmi, tmp_path, cdpr, capfd):
    """Ideal cables pull as commanded, those that stretch by their own equations; what does not stretch is refused."""
    cdpr("export", WINCHES, "-o", "w.fmu", "--fmi", str(fmi), "--only-winch", "--set", "cables[3].model=ideal")
    with Driver(tmp_path / "w.fmu") as driver:
        driver.set("command", np.full(8, 300.0))
        length = driver.get("cable_length")
        driver.step(0.0, 0.001)
        driver.set("command", np.full(8, 400.0))
        driver.set("cable_length", length + 1e-3)
        tension = driver.get("cable_tension")
        assert tension[3] == 400.0  # at once, whatever its length
        others = np.delete(np.arange(8), 3)
        assert np.allclose(tension[others], 300.0 + 1e5 * 1e-3 / length[others] * (1 + 300 / 1e5), rtol=0.02)
        assert driver.get("drum_speed")[3] == 0.0
        assert driver.get("unstretched_length")[3] == length[3] + 1e-3  # all of it
        command = np.full(8, 400.0)
        command[3] = -5.0
        driver.set("command", command)
        assert driver.get("cable_tension")[3] == 0.0
        capfd.readouterr()
        driver.step(0.001, 0.001)
        assert "command[4] is -5 N" in capfd.readouterr().out
    for changes, said in (
        (["cables[2].model=rigid"], "cable 'cable_3' has model rigid: it does not stretch"),
        (["cable.model=rigid"], "cable 'cable_1' has model rigid: it does not stretch"),
        (["cable.model=ideal"], "has ideal cables, so there is no winch to export: set cable.model to elastic"),
    ):
        options = [word for change in changes for word in ("--set", change)]
        assert said in cdpr("export", WINCHES, "-o", "c.fmu", "--only-winch", *options, code=2).stderr
    assert not (tmp_path / "c.fmu").exists()


def test_winches_of_a_scenario_with_actuators_are_those_that_it_exports_itself(tmp_path, cdpr):
    """They take the place of the robot's cables, whatever these are."""
    scenario = str(ROOT / "scenarios" / "winch_fmu.yaml")
    cdpr("export", scenario, "-o", "w.fmu", "--only-winch", "--set", "robot.cable.model=ideal")
    cdpr("export", scenario, "-o", "v.fmu", "--only-winch")
    assert (tmp_path / "w.fmu").read_bytes() == (tmp_path / "v.fmu").read_bytes()


@pytest.mark.slow
def test_the_cache_does_not_grow_without_end(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("CXX", quick_compiler(tmp_path))
    monkeypatch.setattr(archive, "KEPT", 3)
    paths = [cached_fmu(plant_of(scenario("caroca"), 0.001 * (i + 1))) for i in range(5)]
    assert paths[-1].exists()
    assert len(list(paths[-1].parent.glob("*.fmu"))) == 3


def test_no_compiler_is_one_clear_error(tmp_path, cdpr):
    said = cdpr("export", ROBOT, "-o", "a.fmu", code=3, CXX="no-such-compiler").stderr
    assert len(said.splitlines()) == 1
    assert "'no-such-compiler' is not found" in said
    assert "--source-only" in said
    said = cdpr("export", ROBOT, "-o", "a.fmu", code=3, CXX="false", XDG_CACHE_HOME=str(tmp_path / "cache")).stderr
    assert "fails" in said
    assert "--source-only" in said
    assert not list(tmp_path.glob("*.fmu"))
    cdpr("export", ROBOT, "-o", "a.fmu", "--source-only", CXX="no-such-compiler")
    names = list(entries(tmp_path / "a.fmu"))
    assert not [name for name in names if name.startswith("binaries")]
    assert "sources/motion.cpp" in names
    assert validate_fmu(str(tmp_path / "a.fmu")) == []
    said = cdpr("export", ROBOT, "-o", "b.fmu", "--source-only", "--fmi", "2", code=3).stderr
    assert "leave --source-only out, or choose --fmi 3" in said


def test_nothing_is_overwritten_unasked(tmp_path, cdpr):
    (tmp_path / "a.fmu").write_text("mine")
    assert "choose another --out, or --force" in cdpr("export", ROBOT, "-o", "a.fmu", code=8).stderr
    assert (tmp_path / "a.fmu").read_text() == "mine"
    cdpr("export", ROBOT, "-o", "a.fmu", "--force")
    assert open_archive(tmp_path / "a.fmu").description.name == "caroca"
    assert "cannot be written" in cdpr("export", ROBOT, "-o", "a.fmu/b.fmu", code=8).stderr


@pytest.mark.parametrize("step", ["0", "-1", "nan", "inf"])
def test_a_step_is_a_positive_number(step, cdpr):
    assert "greater than 0" in cdpr("export", ROBOT, "-o", "a.fmu", "--step", step, code=2).stderr


@pytest.mark.slow
def test_other_platforms_can_compile_it(tmp_path):
    """Action of `fmpy compile` on an FMU without a binary."""
    from fmpy.build import build_platform_binary

    plant = plant_of(scenario("caroca"))
    path = tmp_path / "source.fmu"
    path.write_bytes(fmu_bytes(plant, 3, source_only=True))
    fmpy.extract(str(path), unzipdir=str(tmp_path / "there"))
    (tmp_path / "build").mkdir()
    build_platform_binary(tmp_path / "there", tmp_path / "build")
    again = tmp_path / "again.fmu"
    with zipfile.ZipFile(again, "w") as packed:
        for file in (tmp_path / "there").rglob("*"):
            packed.write(file, file.relative_to(tmp_path / "there"))
    with Driver(again) as driver:
        assert (driver.state() == plant.state).all()
