"""`cdpr fmu` as a user sees it; it never loads what is in an FMU."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from conftest import ROOT
from fmu_cases import PLANT, description, make_fmu, signals, variable

from cdpr.ui.cli import main

CAROCA = str(ROOT / "scenarios/robots/caroca.yaml")


@pytest.fixture(scope="module")
def telltale(tmp_path_factory):
    """A library whose constructor writes a file, and where that file appears."""
    folder = tmp_path_factory.mktemp("telltale")
    compiler = shutil.which("cc")
    if compiler is None:
        assert not os.environ.get("CI"), "a C compiler is needed"
        pytest.skip("no C compiler")
    written = folder / "written"
    (folder / "a.c").write_text(
        "#include <stdio.h>\n__attribute__((constructor)) static void write(void)"
        f' {{ FILE *f = fopen("{written}", "w"); if (f) fclose(f); }}\n'
    )
    subprocess.run([compiler, "-shared", "-fPIC", "-o", folder / "a.so", folder / "a.c"], check=True)
    subprocess.run([sys.executable, "-c", f"import ctypes; ctypes.CDLL({str(folder / 'a.so')!r})"], check=True)
    assert written.exists()
    written.unlink()
    return (folder / "a.so").read_bytes(), written


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


class Done(NamedTuple):
    stdout: str
    stderr: str


@pytest.fixture
def cdpr(here, monkeypatch, capsys):
    """The command line, in this process."""

    def call(*arguments, code=0):
        monkeypatch.setattr(sys, "argv", ["cdpr", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        done = Done(*capsys.readouterr())
        assert ended.value.code == code, done.stderr
        return done

    return call


@pytest.mark.parametrize("fmi", [2, 3])
def test_no_command_loads_native_code(here, cdpr, telltale, fmi):
    library, written = telltale
    path = str(make_fmu(here / "a.fmu", fmi=fmi, library=library))
    cdpr("fmu", "info", path)
    cdpr("fmu", "check", path, CAROCA, code=2)  # the letter of the standard is not kept
    cdpr("fmu", "map", path, CAROCA)
    cdpr("fmu", "trust", path)
    assert not written.exists()


def test_native_code_runs_only_where_it_is_trusted(here, cdpr, telltale):
    """Its constructor shows whether it ran; more it cannot do, so that a run ends there."""
    library, written = telltale
    path = make_fmu(here / "a.fmu", library=library)
    scenario = yaml.safe_load((ROOT / "scenarios/caroca.yaml").read_text())
    scenario["robot"] = yaml.safe_load(Path(CAROCA).read_text())
    scenario["backend_options"] = {"fmu": {"file": "a.fmu", "isolation": "inproc"}}
    (here / "s.yaml").write_text(yaml.safe_dump(scenario))
    run = ["run", "s.yaml", "--backend", "fmu", "--no-report", "--out"]
    told = cdpr(*run, "refused", code=2).stderr
    assert not written.exists()
    (pin,) = re.findall(r"^  sha256: ([0-9a-f]{64})$", told, re.MULTILINE)

    def loaded(*more):
        done = cdpr(*run, f"out{len(list(here.iterdir()))}", *more, code=2)
        assert "has a library without" in done.stderr
        existed = written.exists()
        written.unlink()
        return existed

    assert loaded("--trust-fmu")
    assert loaded("--set", f"backend_options.fmu.sha256={pin}")
    assert (
        "not the file that the scenario pins"
        in cdpr(*run, "x", "--trust-fmu", "--set", f"backend_options.fmu.sha256={'0' * 64}", code=2).stderr
    )
    cdpr(*run, "y", code=2)  # what was allowed for one run ended with it
    assert not written.exists()
    cdpr("fmu", "trust", "a.fmu")
    assert loaded()
    path.write_bytes(make_fmu(here / "b.fmu", library=library, files={"resources/x": b""}).read_bytes())
    cdpr(*run, "z", code=2)  # another content
    assert not written.exists()


def test_info(here, cdpr):
    path = make_fmu(here / "a.fmu", description(2, canHandleVariableCommunicationStepSize="true"), fmi=2)
    done = cdpr("fmu", "info", "a.fmu")
    lines = done.stdout.splitlines()
    assert lines[0] == "a.fmu: plant, FMI 2.0 co-simulation"
    for line in (
        "  trusted              no: pin the sha256, or 'cdpr fmu trust' it",
        "  binaries             linux64 (runs on this machine); sources not inside",
        "  can                  take steps of any length",
        "  step by default      1 ms",
        "    cable_tension[1] ... [8]    Real  N  0 0 0 0 0 0 0 0",
    ):
        assert line in lines
    told = json.loads(cdpr("fmu", "info", "a.fmu", "--json").stdout)
    assert told["fmi"] == "2.0"
    assert len(told["sha256"]) == 64
    assert len(told["variables"]) == sum(size for _, size, _ in PLANT.values())
    assert told["capabilities"]["variable_step"] is True
    make_fmu(path, platform="win64", fmi=2, identifier="plant")
    assert "win64 (does not run on this machine)" in cdpr("fmu", "info", "a.fmu").stdout


def test_without_the_extra_only_the_letter_of_the_standard_is_not_checked(here, cdpr, monkeypatch):
    monkeypatch.setitem(sys.modules, "fmpy", None)
    monkeypatch.setitem(sys.modules, "fmpy.validation", None)
    make_fmu(here / "a.fmu")
    cdpr("fmu", "info", "a.fmu")
    cdpr("fmu", "map", "a.fmu", CAROCA)
    done = cdpr("fmu", "check", "a.fmu", CAROCA)
    assert "n/a     standard        needs FMPy: pip install 'cdpr[fmu]'" in done.stdout


def test_check(here, cdpr):
    make_fmu(here / "a.fmu", platform="x86_64-windows")
    done = cdpr("fmu", "check", "a.fmu", CAROCA, "--json", code=2)
    outcomes = {each["id"]: each for each in json.loads(done.stdout)["checks"]}
    assert outcomes["archive"]["outcome"] == "passed"
    assert "only for x86_64-windows" in outcomes["binary"]["detail"]
    assert outcomes["signals"]["outcome"] == "passed"
    assert "as a plant: cable_tension, external_wrench -> position" in outcomes["signals"]["detail"]
    done = cdpr("fmu", "check", "a.fmu", code=2)
    assert "n/a     signals         no robot was given" in done.stdout


def test_files_that_cannot_be_opened(here, cdpr):
    (here / "a.fmu").write_text("no zip")
    for command in (["info", "a.fmu"], ["check", "a.fmu"], ["map", "a.fmu", CAROCA], ["trust", "a.fmu"]):
        done = cdpr("fmu", *command, code=2)
        assert done.stdout == ""
        assert done.stderr.strip() == "a.fmu: is not a zip file, or the end of it is missing; an FMU is a zip file"


@pytest.mark.parametrize("fmi", [2, 3])
def test_map_prints_scenario_signals(here, cdpr, fmi):
    """Pasted, it gives the same mapping, although nothing is left to find."""
    from cdpr.fmu.read.archive import open_archive
    from cdpr.fmu.read.mapping import map_signals
    from cdpr.fmu.read.options import Signals
    from cdpr.scenario import load_robot

    more = [variable(fmi, f"omega{i}", 90 + i, "output", unit="rad/s") for i in range(3)]
    rest = {name: row for name, row in PLANT.items() if name != "angular_velocity"}
    path = make_fmu(here / "a.fmu", description(fmi, [*signals(fmi, rest), *more]), fmi=fmi)
    printed = yaml.safe_load(cdpr("fmu", "map", "a.fmu", CAROCA).stdout)
    options = printed["backend_options"]["fmu"]
    archive, robot = open_archive(path), load_robot(CAROCA)
    assert (options["file"], options["sha256"]) == ("a.fmu", archive.sha256)
    assert options["signals"]["outputs"]["angular_velocity"] == "omega{i0}"
    said = Signals.model_validate_json(json.dumps(options["signals"]))
    assert set(said.outputs) == {"position", "quaternion", "velocity", "angular_velocity", "cable_length"}
    pasted, found = map_signals(archive.description, robot, said), map_signals(archive.description, robot)
    assert set(pasted.outputs.ports) == set(found.outputs.ports)
    for name, port in found.outputs.ports.items():
        assert pasted.outputs.ports[name].rule == "given"
        assert pasted.outputs.ports[name].index.tolist() == port.index.tolist()
    told = json.loads(cdpr("fmu", "map", "a.fmu", CAROCA, "--json").stdout)
    assert told["problems"] == []
    assert told["role"] == "plant"


@pytest.mark.parametrize("command", ["check", "map"])
def test_signals_of_the_scenario_are_used(here, cdpr, command):
    """Pose and twist of another author; one scenario assigns them, another has a mistake."""
    rest = {name: row for name, row in PLANT.items() if name != "position"}
    more = [variable(3, "A", 90, "output", shape=(3,), unit="m"), variable(3, "B", 91, "output", shape=(3,), unit="m")]
    make_fmu(here / "a.fmu", description(3, [*signals(3, rest), *more]))
    scenario = yaml.safe_load((ROOT / "scenarios/caroca.yaml").read_text())
    scenario["robot"] = yaml.safe_load(Path(CAROCA).read_text())
    for name, position in (("good", "B"), ("bad", "C")):
        scenario["backend_options"] = {"fmu": {"file": "a.fmu", "signals": {"outputs": {"position": position}}}}
        (here / f"{name}.yaml").write_text(yaml.safe_dump(scenario))
    good = cdpr("fmu", command, "a.fmu", "good.yaml", code=2 if command == "check" else 0)
    assert ("passed  signals" if command == "check" else "position: B") in good.stdout
    bad = cdpr("fmu", command, "a.fmu", "bad.yaml", code=2)
    assert "signals.outputs.position: no output with 3 numbers is named 'C'" in bad.stdout + bad.stderr
    other = cdpr("fmu", command, "a.fmu", CAROCA, code=2)
    assert "signals.outputs.position: needed, but there is no output" in other.stdout + other.stderr


def test_map_leaves_to_the_user_what_is_not_certain(here, cdpr):
    rest = {name: row for name, row in PLANT.items() if name not in ("position", "cable_tension")}
    more = [variable(3, name, 90 + i, "output", shape=(3,), unit="m") for i, name in enumerate(["r", "pos"])]
    make_fmu(here / "a.fmu", description(3, [*signals(3, rest), *more]))
    done = cdpr("fmu", "map", "a.fmu", CAROCA, code=2)
    assert "        # position:  # not found; needed" in done.stdout.splitlines()
    assert "signals.outputs.position: ambiguous: pos or r; choose one under signals.outputs" in done.stderr
    assert "signals.inputs: cable_tension (8 numbers) or command (8 numbers) is needed" in done.stderr
    assert "position" not in yaml.safe_load(done.stdout)["backend_options"]["fmu"]["signals"]["outputs"]


def test_a_controller_is_distinguished_from_a_plant(here, cdpr):
    table = {"position": ("input", 3, "m"), "desired_position": ("input", 3, "m"), "wrench": ("output", 6, None)}
    make_fmu(here / "a.fmu", description(3, signals(3, table)))
    printed = yaml.safe_load(cdpr("fmu", "map", "a.fmu", CAROCA).stdout)
    assert printed["controller"]["type"] == "fmu"
    assert printed["controller"]["signals"]["outputs"] == {"wrench": "wrench"}
    assert "--as" in cdpr("fmu", "map", "a.fmu", CAROCA, "--as", "robot", code=2).stderr


def test_trust(here, cdpr):
    path = make_fmu(here / "a.fmu")
    assert "no FMU is trusted" in cdpr("fmu", "trust").stderr
    assert "trusted: " in cdpr("fmu", "trust", "a.fmu").stderr
    (row,) = json.loads(cdpr("fmu", "trust", "--json").stdout)
    assert row["name"] == "a.fmu"
    assert cdpr("fmu", "trust").stdout == f"{row['sha256']}  a.fmu\n"
    assert "yes, on your list" in cdpr("fmu", "info", "a.fmu").stdout
    path.unlink()
    cdpr("fmu", "trust", "--remove", row["sha256"])
    assert cdpr("fmu", "trust").stdout == ""
    assert "is not on the list" in cdpr("fmu", "trust", "--remove", row["sha256"], code=2).stderr
    assert "--remove needs FILE" in cdpr("fmu", "trust", "--remove", code=2).stderr


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("path", sorted((ROOT / "scenarios/robots").glob("*.yaml")), ids=lambda path: path.stem)
@pytest.mark.usual("*-3")  # exports of FMI 2 are compiled
def test_exports_of_cdpr_are_mapped_automatically(here, path, fmi):
    from cdpr.fmu.export import Plant, fmu_bytes
    from cdpr.fmu.read.archive import open_archive
    from cdpr.fmu.read.mapping import map_signals
    from cdpr.mechanics.kinematics import make_state
    from cdpr.scenario import load_robot

    robot = load_robot(path)
    plant = Plant(robot, np.array([0.0, 0.0, -9.81]), 0.001, make_state(np.zeros(3)))
    (here / "a.fmu").write_bytes(fmu_bytes(plant, fmi, source_only=fmi == 3))
    about = open_archive(here / "a.fmu").description
    mapping = map_signals(about, robot)
    assert mapping.notices == ()
    assert set(mapping.inputs.ports) >= {"external_wrench"}
    assert {port.rule for port in mapping.outputs.ports.values()} == {"name"}
    assert {"position", "quaternion", "velocity", "angular_velocity", "cable_length", "cable_rate"} == set(
        mapping.outputs.ports
    )


def test_help_names_the_commands(cdpr):
    done = cdpr("fmu", "--help")
    for name in ("info", "check", "map", "trust"):
        assert f"  {name} " in done.stdout


def test_commands_that_load_a_scenario_take_its_plugins(here, cdpr):
    """The suggested correction of an unknown name works."""
    (here / "mine.py").write_text(
        "from cdpr.plugins import TensionSolver\n\n\nclass Mine(TensionSolver):\n"
        "    def solve(self, W, wrench, t_min, t_max, tension):\n        return 0\n"
    )
    shutil.copytree(ROOT / "scenarios", here / "scenarios")
    scenario = here / "scenarios" / "mine.yaml"
    scenario.write_text(
        yaml.safe_dump({**yaml.safe_load(Path("scenarios/caroca.yaml").read_text()), "solver": {"type": "Mine"}})
    )
    fmu = str(make_fmu(here / "a.fmu"))
    commands = [
        ("fmu", "export", str(scenario), "--out", "b.fmu", "--source-only"),
        ("fmu", "map", fmu, str(scenario)),
        ("export", str(scenario), "--to", "ros2"),
        ("size", str(scenario)),
        ("workspace", "static", str(scenario), "--cells", "2"),
    ]
    assert "--plugin FILE adds your own" in cdpr(*commands[0], code=3).stderr
    for command in commands:
        cdpr(*command, "--plugin", "mine.py")
    assert cdpr("fmu", "check", fmu, str(scenario), "--plugin", "mine.py", code=2).stderr == ""  # other letters
