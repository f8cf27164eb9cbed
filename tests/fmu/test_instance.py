"""One FMU in this process and in one of its own: the same calls, the same answers, nothing left behind."""

from __future__ import annotations

import gc
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
from conftest import ROOT
from fmu.controller import ENDS, STANDS_STILL, write_controller

from cdpr.base.errors import BackendDied, FmuError, PlantEnded
from cdpr.base.temporary import sweep
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.options import FmuFile
from cdpr.fmu.run.folder import PREFIX
from cdpr.fmu.run.running import RunningFmu
from cdpr.scenario import load_robot
from cdpr.testing.process import descriptors, resident_bytes, threads

pytest.importorskip("fmpy")

POINT_MASS = load_robot(ROOT / "scenarios/robots/point_mass.yaml")
BOTH = pytest.mark.parametrize("isolation", ["inproc", "process"])


@pytest.fixture(autouse=True)
def own_temporary_folder(monkeypatch, tmp_path):
    """Other processes of this machine may run FMUs, too."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The controller in FMI 2 and 3."""
    folder = tmp_path_factory.mktemp("fmu")
    return {fmi: write_controller(folder / f"controller{fmi}.fmu", fmi) for fmi in (2, 3)}


def running(path, isolation="inproc", mode=0.0, **options):
    fmu = RunningFmu(
        open_archive(path),
        "lab",
        "controller",
        POINT_MASS,
        1e-3,
        FmuFile(parameters={"kp": 100.0, "kd": 20.0, "mode": mode}, **options),
        isolation,
    )
    fmu.start({"mass": (5.0, "kg"), "gravity": (np.array([0.0, 0.0, -9.81]), "m/s^2")})
    return fmu


def temporary_folders():
    return {path.name for path in Path(tempfile.gettempdir()).glob("cdpr-fmu-*")}


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@BOTH
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.usual("2-inproc", "3-*")
def test_inputs_go_in_and_outputs_come_out(files, fmi, isolation):
    fmu = running(files[fmi], isolation)
    instance, inputs = fmu.instance, fmu.mapping.inputs.ports
    x, v, to = np.array([0.1, 0.2, 0.3]), np.array([-1.0, 0.5, 0.25]), np.array([1.0, 2.0, 3.0])
    for name, value in (("position", x), ("velocity", v), ("desired_position", to)):
        inputs[name].write(value, instance.inputs)
    instance.step(2)
    wrench = np.zeros(6)
    fmu.mapping.outputs.ports["wrench"].read(instance.outputs, wrench)
    np.testing.assert_allclose(wrench[:3], 5.0 * (100.0 * (to - x) - 20.0 * v) + [0, 0, 49.05], rtol=1e-14)
    assert instance.time == 0.002
    fmu.close()
    fmu.close()


@BOTH
def test_closed_it_leaves_nothing_and_is_not_called(files, isolation):
    before, folder = temporary_folders(), os.getcwd()
    fmu = running(files[3], isolation)
    assert len(temporary_folders() - before) == 1
    fmu.close()
    assert temporary_folders() == before
    assert os.getcwd() == folder
    for call in (lambda: fmu.instance.step(1), fmu.instance.refresh, lambda: fmu.start({})):
        with pytest.raises(BackendDied):
            call()


@BOTH
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.usual("3-inproc")
def test_it_may_end_the_simulation(files, fmi, isolation):
    fmu = running(files[fmi], isolation, mode=ENDS)
    fmu.instance.step(2)
    with pytest.raises(PlantEnded, match="requested the end"):
        fmu.instance.step(1)
    fmu.start({})  # and go on from the start
    fmu.instance.step(2)
    fmu.close()


@BOTH
@pytest.mark.usual("inproc")
def test_an_fmu_that_does_not_reach_the_time_is_found_out(files, isolation):
    fmu = running(files[3], isolation, mode=STANDS_STILL)
    with pytest.raises(BackendDied, match=r"was to go to 0\.001 s, but reports 0 s"):
        fmu.instance.step(1)
    fmu.close()


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.usual("3")
def test_a_missing_function_is_named(tmp_path, fmi):
    path = write_controller(tmp_path / "half.fmu", fmi, "-DWITHOUT_STEP")
    before = temporary_folders()
    with pytest.raises(FmuError, match=f"FMU 'lab' has a library without fmi{fmi}DoStep, which FMI requires"):
        running(path)
    with pytest.raises(FmuError, match=f"fmi{fmi}DoStep"):
        running(path, "process")
    assert temporary_folders() == before


def test_a_step_that_the_fmu_cannot_do_is_refused(tmp_path):
    path = write_controller(tmp_path / "fixed.fmu", 3, fixedInternalStepSize="0.003")
    with pytest.raises(FmuError, match=r"its own step is 0\.003 s, and 0\.001 s is not a multiple"):
        running(path)


def test_a_shorter_step_than_that_of_the_description_warns_in_fmi_2(files):
    archive = open_archive(files[2])  # made for 1 ms
    with pytest.warns(UserWarning, match=r"step of 0\.0005 s is shorter than the 0\.001 s"):
        RunningFmu(archive, "lab", "controller", POINT_MASS, 5e-4, FmuFile(), "inproc").close()


def test_messages_of_fmi_2_are_formatted(files):
    fmu = running(files[2])
    assert fmu.instance.log[0] == "lab made at 7"
    fmu.close()


def test_a_parameter_that_the_fmu_does_not_have_is_reported(files):
    fmu = RunningFmu(
        open_archive(files[3]), "lab", "controller", POINT_MASS, 1e-3, FmuFile(parameters={"kpp": 1.0}), "inproc"
    )
    with pytest.raises(FmuError, match="no variable 'kpp'"):
        fmu.start({})
    fmu.close()


def test_an_fmu_for_one_instance_has_one_in_a_process(tmp_path):
    path = write_controller(tmp_path / "once.fmu", 3, canBeInstantiatedOnlyOncePerProcess="true")
    first, apart = running(path), running(path, "process")
    with pytest.raises(FmuError, match="only once in a process; choose isolation: process"):
        running(path)
    first.close()
    apart.close()
    running(path).close()


def test_a_killed_process_is_reported(files):
    fmu = running(files[3], "process")
    os.kill(fmu.instance.pid, signal.SIGKILL)
    with pytest.raises(BackendDied, match="SIGKILL"):
        fmu.instance.step(1)
    fmu.close()


FOLDERS = [ROOT / "tests", ROOT / "tests" / "support", ROOT / "tests" / "fmu"]
ORPHAN = """
import os, signal, sys
sys.path[:0] = sys.argv[2:]
from test_instance import running
fmu = running(sys.argv[1], "process")
print(fmu.instance.pid, fmu.instance.plan.resources, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow
def test_a_process_does_not_outlive_its_parent(files):
    command = [sys.executable, "-c", ORPHAN, str(files[3]), *map(str, FOLDERS)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == -signal.SIGKILL, done.stderr
    pid, resources = done.stdout.split()
    deadline = monotonic() + 10.0
    while alive(pid) and monotonic() < deadline:
        sleep(0.05)
    assert not alive(pid)
    sweep(str(Path(resources).parents[1]), PREFIX)  # as the next process that runs an FMU does
    assert not Path(resources).parent.exists()


COLLECTED = 50  # cycles: Python collects the more seldom the more lives, and other tests have left much


def cycles(path, isolation, count):
    for k in range(count):
        fmu = running(path, isolation)
        fmu.instance.step(1)
        fmu.close()
        if k % COLLECTED == 0:
            gc.collect()
    gc.collect()
    return descriptors(), threads(), resident_bytes()


def check_leaks(path, isolation, first, then):
    gc.collect()  # instances left open by other tests
    before, folders = cycles(path, isolation, first), temporary_folders()
    after = cycles(path, isolation, then)
    assert after[0] == before[0]
    assert after[1] == before[1]
    assert after[2] - before[2] < 2e6
    assert temporary_folders() == folders


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_twenty_cycles_leave_nothing(files, fmi):
    check_leaks(files[fmi], "inproc", 10, 20)


@pytest.mark.slow
def test_a_few_processes_leave_nothing(files):
    check_leaks(files[3], "process", 2, 4)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_thousand_cycles_leave_nothing(files, fmi):
    check_leaks(files[fmi], "inproc", 100, 1000)


@pytest.mark.slow
def test_a_hundred_processes_leave_nothing(files):
    check_leaks(files[3], "process", 5, 100)


def test_fmpy_declares_what_is_bound():
    """A canary for FMPy's versions: without a type a function would take whatever comes."""
    from cdpr.fmu.run.slave import NEEDED, Slave2, Slave3, signature

    for version in (Slave2, Slave3):
        names = {*NEEDED, *version.needed, *version.other, f"Get{version.real}"}
        names |= {f"Set{kind}" for kind in (version.real, *version.kinds)}
        names |= {f"{verb}{version.state}" for verb in ("Get", "Set", "Free")}
        for name in names:
            arguments, result = signature(version.declared, version.prefix + name)
            assert all(re.match("c_|LP_|CFunctionType", kind.__name__) for kind in arguments), name
            assert arguments[0].__name__ == ("c_char_p" if name.startswith("Instantiate") else "c_void_p")
            assert result is None or result.__name__ in ("c_int", "c_void_p"), name
