"""Expectations of users of exported FMUs: derivatives, bounds, tunable parameters, terminals, logs, platforms."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import signal
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from fmu.cases import FMI, load, plant_of, scenario, write
from fmu.driver import STATE, Driver
from lxml import etree
from spread import spread

from cdpr.base.errors import PluginError
from cdpr.fmu.export import Actuator, fmu_bytes
from cdpr.fmu.export.library import CROSS, IDENTIFIER
from cdpr.fmu.read.archive import open_archive


@FMI
def test_numbers_have_bounds_and_usual_sizes(fmi, tmp_path):
    loaded = scenario("cogiro")
    about = fmpy.read_model_description(str(write(plant_of(loaded), fmi, tmp_path)))
    by_name = {variable.name.split("[")[0]: variable for variable in about.modelVariables}
    pull, most = by_name["cable_tension"], float(loaded.robot.tension_max.max())
    assert (float(pull.min), float(pull.max), float(pull.nominal)) == (0.0, most, 0.5 * most)
    assert float(by_name["mass"].min) == 0.0
    assert float(by_name["mass"].nominal) == loaded.robot.platform.mass
    assert by_name["position"].min is None
    for variable in about.modelVariables:
        if variable.start is not None and variable.min is not None:
            assert min(map(float, str(variable.start).split())) >= float(variable.min)
        assert variable.nominal is None or float(variable.nominal) > 0.0


TUNED = {"caroca": "mass", "spherical": "inertia", "planar": "platform_anchors", "cogiro_elastic": "mass"}


@spread("case, fmi", list(TUNED), [2, 3])
def test_after_tuning_it_equals_a_controller_with_these_gains(case, fmi, tmp_path):
    """The platform neither jumps nor gets another velocity."""
    loaded, name = scenario(case), TUNED[case]
    plant = plant_of(loaded)
    pull = "command" if plant.winches else "cable_tension"
    path = write(plant, fmi, tmp_path)
    with Driver(path) as driver:
        driver.set(pull, np.abs(load(plant, 0.0)[0]))
        driver.step(0.0, 0.05)
        before = driver.state()
        driver.set(name, driver.get(name) * 1.25)
        assert np.allclose(driver.state(), before, rtol=0.0, atol=1e-14)
        tuned = {name: driver.get(name)}
        if plant.winches:  # those of the other would begin anew
            assert driver.get("acceleration") @ driver.get("acceleration") > 0.0
            driver.step(0.05, 0.05)
            return
        start = dict(zip([f"initial_{each}" for each in STATE], np.split(before, [3, 7, 10]), strict=True))
        with Driver(path, {**start, **tuned}) as other:
            other.set(pull, np.abs(load(plant, 0.0)[0]))
            for k in range(20):
                driver.step(0.05 + 0.01 * k, 0.01)
                other.step(0.01 * k, 0.01)
            assert np.allclose(driver.state(), other.state(), rtol=0.0, atol=1e-11)
            assert np.allclose(driver.get("acceleration"), other.get("acceleration"), rtol=0.0, atol=1e-9)


@FMI
def test_unstable_tuning_is_reported_and_can_be_corrected(fmi, tmp_path, capfd):
    plant = plant_of(scenario("caroca"))
    with Driver(write(plant, fmi, tmp_path)) as driver:
        driver.step(0.0, 0.01)
        saved = driver.save()
        driver.set("mass", -1.0)
        with pytest.raises(FMICallException):
            driver.step(0.01, 0.01)
        assert "mass must be greater than 0" in capfd.readouterr().out
        driver.set("mass", 160.0)
        at = driver.save()  # between setting and computing
        driver.step(0.01, 0.01)
        end = driver.state()
        driver.restore(at)
        driver.step(0.01, 0.01)
        assert (driver.state() == end).all()
        driver.restore(saved)
        assert driver.get("mass") == plant.robot.platform.mass
        with pytest.raises(FMICallException):
            driver.set("initial_position", np.zeros(3))  # not tunable


@FMI
@pytest.mark.parametrize("name", ["cable_tension", "mass"])
def test_ended_it_stays_where_it_is(fmi, name, tmp_path):
    """Also if something was set for a step that did not come."""
    with Driver(write(plant_of(scenario("caroca")), fmi, tmp_path)) as driver:
        driver.set("cable_tension", np.linspace(100.0, 400.0, 8))
        driver.step(0.0, 0.1)
        before = driver.state()
        driver.set(name, 1.5 * driver.get(name))
        driver.fmu.terminate()
        assert np.allclose(driver.state(), before, rtol=0.0, atol=1e-14)


@FMI
def test_after_restore_negative_tension_is_reported_again(fmi, tmp_path, capfd):
    """A snapshot contains all state that affects answers, including given warnings."""
    with Driver(write(plant_of(scenario("caroca")), fmi, tmp_path)) as driver:
        driver.step(0.0, 0.01)
        driver.set("cable_tension", np.full(8, -5.0))
        saved = driver.save()
        for _ in range(2):
            capfd.readouterr()
            driver.step(0.01, 0.01)
            assert "cannot push" in capfd.readouterr().out
            driver.restore(saved)


@FMI
@pytest.mark.parametrize("step", [1e-30, 5e-324])
@pytest.mark.usual("1e-30-3", "5e-324-2")
def test_a_step_that_would_never_end_is_refused(fmi, step, tmp_path):
    """In a process of its own: what never ends there does not listen to Python."""
    with Driver(write(plant_of(scenario("caroca")), fmi, tmp_path)) as driver:
        driver.set("physics_step", [step])
        child = os.fork()
        if child == 0:
            signal.alarm(5)
            try:
                driver.step(0.0, 0.01)
            except FMICallException:
                os._exit(3)
            os._exit(4)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3


@FMI
def test_an_earlier_snapshot_is_overwritten_and_no_other_memory(fmi, tmp_path, capfd):
    """The standard lets a host hand one back; what is none is refused, and stays."""
    with Driver(write(plant_of(scenario("caroca")), fmi, tmp_path)) as driver:
        get = driver.fmu.fmi3GetFMUState if fmi == 3 else driver.fmu.fmi2GetFMUstate
        driver.set("cable_tension", np.full(8, 200.0))
        saved = driver.save()
        before = saved.value
        driver.step(0.0, 0.01)
        later = driver.state()
        get(driver.fmu.component, ctypes.byref(saved))
        assert saved.value == before  # no other memory is taken
        driver.step(0.01, 0.01)
        driver.restore(saved)
        np.testing.assert_array_equal(driver.state(), later)
        rubbish = ctypes.create_string_buffer(b"\xa5" * 65536, 65536)
        with pytest.raises(FMICallException):
            get(driver.fmu.component, ctypes.byref(ctypes.c_void_p(ctypes.addressof(rubbish))))
        assert "not a snapshot of this FMU" in capfd.readouterr().out
        assert rubbish.raw == b"\xa5" * 65536


def told(driver, capfd, on, categories):
    """Messages about a step with a negative tension, and about other parameters."""
    driver.fmu.setDebugLogging(on, categories)
    capfd.readouterr()
    time = float(driver.get("time")[0])
    driver.set("cable_tension", np.full(8, 100.0))
    driver.set("mass", 150.0)
    driver.step(time, 0.01)
    driver.set("cable_tension", np.full(8, -5.0))
    driver.step(time + 0.01, 0.01)
    said = capfd.readouterr().out
    return "cannot push" in said, "other parameters" in said


def test_messages_come_by_their_categories(tmp_path, capfd):
    with Driver(write(plant_of(scenario("caroca")), 3, tmp_path)) as driver:
        assert told(driver, capfd, True, ["logEvents"]) == (False, True)
        assert told(driver, capfd, True, ["logStatusWarning"]) == (True, False)
        assert told(driver, capfd, True, ["logAll"]) == (True, True)
        assert told(driver, capfd, False, []) == (True, False)  # errors are always reported
        assert told(driver, capfd, True, []) == (True, True)
        with pytest.raises(FMICallException):
            driver.fmu.setDebugLogging(True, ["logEverything"])
        assert "no category 'logEverything'" in capfd.readouterr().out


def schema():
    folder = Path(fmpy.__file__).parent / "schema" / "fmi3"
    return etree.XMLSchema(file=str(folder / "fmi3TerminalsAndIcons.xsd"))


@pytest.mark.parametrize("kind", ["plant", "winches inside", "winches alone"])
def test_terminal_output_keeps_units_together(kind, tmp_path):
    loaded = scenario("caroca" if kind == "plant" else "cogiro_elastic")
    model = plant_of(loaded) if kind != "winches alone" else Actuator(loaded.robot, 1e-3)
    path = tmp_path / "a.fmu"
    path.write_bytes(fmu_bytes(model, 3))
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as packed:
        content = packed.read("terminalsAndIcons/terminalsAndIcons.xml")
    schema().assertValid(etree.fromstring(content))
    names = [terminal.get("name") for terminal in etree.fromstring(content).iter("Terminal")]
    expected = {"plant": {"platform", "cables"}, "winches alone": {"winches", "cables"}}
    assert set(names) == expected.get(kind, {"platform", "cables", "winches"})
    opened = open_archive(path)
    variables = {variable.name for variable in fmpy.read_model_description(str(path)).modelVariables}
    assert len(opened.description.terminals) == len(names)
    for members in opened.description.terminals:
        assert set(members.values()) <= variables
    path.write_bytes(fmu_bytes(model, 2))  # there are none in FMI 2
    with zipfile.ZipFile(path) as packed:
        assert not [name for name in packed.namelist() if "terminals" in name]


def test_cables_of_plant_and_winches_fit_together(tmp_path):
    """Outputs of one are inputs of the other, with the same names."""
    loaded = scenario("cogiro_elastic")
    roles = []
    for model in (plant_of(scenario("cogiro")), Actuator(loaded.robot, 1e-3)):
        cables = {v.name: v.causality for v in model.variables() if v.terminal == "cables"}
        roles.append(cables)
    assert set(roles[0]) == set(roles[1]) == {"cable_tension", "cable_length", "cable_rate"}
    assert all({roles[0][name], roles[1][name]} == {"input", "output"} for name in roles[0])


def test_rigid_drums_declare_direct_effects(tmp_path):
    plant = plant_of(scenario("cogiro_rigid"))
    about = fmpy.read_model_description(str(write(plant, 3, tmp_path)))
    at_once = {u.variable.name: u.dependencies for u in about.outputs}
    assert at_once["cable_tension"] is None  # all
    assert {v.name for v in at_once["acceleration"]} == {"command", "external_force", "external_moment"}
    assert at_once["position"] == []


@pytest.mark.slow
@pytest.mark.skipif(shutil.which(CROSS) is None, reason="no compiler for Windows")
def test_windows_gets_the_same_bytes_each_time(tmp_path, monkeypatch):
    made = []
    for name in ("one", "another place"):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / name))
        made.append(fmu_bytes(plant_of(scenario("caroca")), 3, platforms=("win64",)))
    assert made[0] == made[1]
    path = tmp_path / "w.fmu"
    path.write_bytes(made[0])
    assert validate_fmu(str(path)) == []
    assert "win64" in fmpy.supported_platforms(str(path))
    with zipfile.ZipFile(path) as packed:
        binary = packed.read(f"binaries/x86_64-windows/{IDENTIFIER}.dll")
    assert binary.startswith(b"MZ")
    assert b"fmi3DoStep\0" in binary  # exported by name
    assert b"libgcc" not in binary  # nothing that Windows does not have
    two = fmu_bytes(plant_of(scenario("caroca")), 2, platforms=("native", "win64"))
    path.write_bytes(two)
    assert {"linux64", "win64"} <= set(fmpy.supported_platforms(str(path)))


def test_without_a_compiler_for_windows_its_name_is_reported(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("cdpr.fmu.export.library.zig_program", lambda: None)
    with pytest.raises(PluginError, match=re.escape(f"for win64: install '{CROSS}'")):
        fmu_bytes(plant_of(scenario("caroca")), 3, platforms=("win64",))
