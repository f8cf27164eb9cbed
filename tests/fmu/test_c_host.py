"""Exported FMUs in hosts that are not Python, and under the compiler's sanitizers."""

from __future__ import annotations

import subprocess
import zipfile

import numpy as np
import pytest
from fmu.cases import plant_of, scenario, write
from fmu.driver import Driver
from fmu.host import STEP, STEPS, STRICT, arguments, compile_host

from cdpr.fmu.export.library import FLAGS, library, sources
from cdpr.fmu.read.archive import open_archive

SANITIZE = ("-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")

CASES = pytest.mark.parametrize("case", ["caroca", "planar", "cogiro_elastic", "cogiro_rigid", "pulleys_mixed"])


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return compile_host(tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory):
    """Host and library with sanitizers, compiled without optimization, which would take most of the compiler's time."""
    folder = tmp_path_factory.mktemp("sanitized")
    shared = folder / "cdpr_plant.so"
    shared.write_bytes(library(sources(), (*FLAGS, *STRICT, "-Wpedantic", *SANITIZE, "-O0")))
    return compile_host(folder, flags=SANITIZE), shared


def run(host, path, folder, shared=None):
    """Extract the FMU and run the host on it; return what came of it."""
    return subprocess.run([host, *arguments(path, folder, shared)], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("fmi", [2, 3])
@CASES
@pytest.mark.usual("*-3", "caroca-2")
def test_a_host_in_c_finds_the_same(case, fmi, plain, tmp_path):
    """It also saves, serialises and restores on its way."""
    plant = plant_of(scenario(case))
    path = write(plant, fmi, tmp_path)
    done = run(plain, path, tmp_path / "extracted mit ä")
    assert done.returncode == 0, done.stderr
    with Driver(path) as driver:
        driver.set("command" if plant.winches else "cable_tension", 200.0 + 10.0 * np.arange(plant.robot.m))
        driver.set("external_force", [1.0, 2.0, 3.0])
        driver.set("external_moment", [4.0, 5.0, 6.0])
        for k in range(STEPS):
            driver.step(k * STEP, STEP)
        assert [float(line) for line in done.stdout.split()] == driver.state().tolist()


@pytest.mark.slow
def test_a_compiler_without_vector_types_gives_the_same_bits(plain, tmp_path):
    path = write(plant_of(scenario("pulleys_mixed")), 3, tmp_path)
    shared = tmp_path / "plain.so"
    shared.write_bytes(library(sources(), (*FLAGS, *STRICT, "-Wpedantic", "-DCDPR_PLAIN")))
    states = [run(plain, path, tmp_path / str(k), given).stdout for k, given in enumerate((None, shared))]
    assert len(states[0].split()) == 13
    assert states[0] == states[1]


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@CASES
def test_sanitizers_find_nothing(case, fmi, sanitized, tmp_path):
    host, shared = sanitized
    done = run(host, write(plant_of(scenario(case)), fmi, tmp_path), tmp_path / "extracted", shared)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split()) == 13


@pytest.mark.parametrize(
    ("case", "more"),
    [
        (
            "caroca",
            [
                (" mass kg 2 1 ", " mass kg 9999 1 "),
                (" mass kg 2 1 ", " mass kg 2 99999 "),
                ("parameter mass", "nothing mass"),
            ],
        ),
        (
            "mixed",
            [
                ("chains memory 264", "chains memory 151"),
                ("chains memory", "chain memory"),
                ("chains memory 264 3ff", "chains memory 264 7ff"),
            ],
        ),
        ("mixed", [("\n18 3 0 0 ", "\n18 99999 0 0 "), ("lines memory", "lines memory 9")]),
    ],
)
@pytest.mark.slow
def test_a_damaged_configuration_is_refused(case, more, sanitized, tmp_path):
    """Cut anywhere, or with numbers that lead out of the arrays: a message and no instance."""
    host, shared = sanitized
    path = write(plant_of(scenario(case)), 3, tmp_path)
    with zipfile.ZipFile(path) as archive:
        whole = archive.read("resources/plant.cfg").decode()
    damaged = [whole[:length] for length in range(0, len(whole) - 17, 211 if case == "caroca" else 2011)]
    changes = [
        *[("cables 8", f"cables {number}") for number in ("9", "999999", "-1")],
        *[("numbers ", "numbers 9"), ("variables ", "variables 9")],
        *[("parameter mass", f"{other}") for other in ("parameter masse", "parameter gravity")],
        *more,
    ]
    for old, new in changes:
        assert old in whole
        damaged.append(whole.replace(old, new, 1))
    for number, text in enumerate(damaged):
        with zipfile.ZipFile(tmp_path / "damaged.fmu", "w") as copy, zipfile.ZipFile(path) as archive:
            for info in archive.infolist():
                copy.writestr(info, text if info.filename == "resources/plant.cfg" else archive.read(info))
        done = run(host, tmp_path / "damaged.fmu", tmp_path / str(number), shared)
        assert done.returncode == 2, (text[:100], done.stderr)
        assert "plant.cfg" in done.stderr


def test_libcosim_takes_it(tmp_path):
    """An importer that is not FMPy. It takes FMI 2 alone."""
    libcosimpy = pytest.importorskip("libcosimpy", reason="libcosimpy is not installed: pip install libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    assert libcosimpy
    plant = plant_of(scenario("caroca"))
    path = write(plant, 2, tmp_path)
    about = open_archive(path).description
    tension = [about.find(f"cable_tension[{i + 1}]").value_reference for i in range(8)]
    position = [about.find(f"position[{i + 1}]").value_reference for i in range(3)]
    execution = CosimExecution.from_step_size(step_size=1_000_000)  # ns
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name="plant"))
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    assert execution.add_manipulator(manipulator=manipulator)
    assert execution.add_observer(observer=observer)
    command = 200.0 + 10.0 * np.arange(8)
    assert manipulator.slave_real_values(slave_index=slave, variable_references=tension, values=command.tolist())
    assert execution.step(step_count=STEPS)
    found = observer.last_real_values(slave_index=slave, variable_references=position)
    with Driver(path) as driver:
        driver.set("cable_tension", command)
        for k in range(STEPS):
            driver.step(k * STEP, STEP)
        assert np.abs(np.array(found) - driver.get("position")).max() < 1e-12
