"""`cdpr export --to native`: files, their checks, and programs that reproduce a run's tensions to the bit."""

from __future__ import annotations

import ctypes
import subprocess
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from native_compiler import tool

from cdpr import load_robot, load_scenario, simulate
from cdpr.base.errors import CdprError, OutputError
from cdpr.formats.write.native import HEADER, NUMBERS, native_files, write_native
from cdpr.formats.write.native.header import flattened
from cdpr.log.export import export
from cdpr.ui.cli.export import command

EXAMPLE = ROOT / "examples" / "realtime"
FLAGS = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-fno-exceptions", "-fno-rtti"]
OK, REPLACED, NO_ANSWER, NOT_FINITE, BAD_INPUT, NOT_READY = range(6)
BAD_SIZE, BAD_MAGIC, BAD_VERSION, OTHER_ROBOT, BAD_CHECKSUM = range(6, 11)

CASES = {
    "qp": ("caroca", []),
    "pid": ("caroca", ["controller={type: pid, kp: 100, kd: 20, ki: 50}"]),
    "replaced": ("caroca", ["solver.type=closed_form", "solver.infeasible=hold_tension"]),
    "planar": ("planar", ["solver.type=p_norm"]),
    "pulleys": ("cogiro_pulleys", ["solver.type=dykstra"]),
    "cable_length": ("planar", ["controller.type=cable_length"]),
    "stopping": ("helix", ["events=[{type: emergency_stop, time: 0.4, stopping_time: 0.3}]"]),
}


def scenario(name, changes=()):
    path = ROOT / "scenarios" / f"{name}.yaml"
    return load_scenario(path, overrides=[*changes, "simulation.duration=1.0"])


def test_the_same_scenario_gives_the_same_bytes(tmp_path):
    loaded = scenario("caroca")
    files = native_files(loaded)
    assert set(files) == {HEADER, NUMBERS}
    junk = [np.full(size, 7.7) for size in range(1, 200)]
    del junk  # which new arrays without content may have
    assert files == native_files(scenario("caroca"))
    assert [path.read_bytes() for path in write_native(loaded, tmp_path)] == list(files.values())
    with pytest.raises(OutputError, match="force=True"):
        write_native(loaded, tmp_path)
    write_native(loaded, tmp_path, force=True)


def test_other_numbers_fit_the_same_header():
    one, other = (native_files(scenario("caroca", [f"controller.kp={kp}"])) for kp in (80, 90))
    assert one[HEADER] == other[HEADER]
    assert one[NUMBERS] != other[NUMBERS]
    assert native_files(scenario("planar"))[HEADER] != one[HEADER]


def test_the_header_includes_only_the_c_library():
    text = native_files(scenario("caroca"))[HEADER].decode()
    included = {line.split()[1] for line in text.splitlines() if line.startswith("#include")}
    assert all(name.endswith(".h>") and "/" not in name for name in included), included
    assert not any(line.rstrip() == "#pragma once" or "@" in line for line in text.splitlines())


def test_each_header_is_inserted_once():
    headers = {"a.hpp": "#pragma once\n#include <b.hpp>\nA\n", "b.hpp": "#pragma once\n#include <stdint.h>\nB\n"}
    text = flattened("#include <b.hpp>\n#include <a.hpp>\nC\n", headers)
    assert text.split("\n") == ["#include <stdint.h>", "B", "A", "C", ""]


def test_a_solver_of_a_library_is_refused():
    with pytest.raises(CdprError, match="solver 'exact' has no compiled operation"):
        native_files(scenario("caroca", ["solver.type=exact"]))


def test_actuators_are_refused_without_naming_another_export():
    with pytest.raises(CdprError, match=r"actuators: .*: an exported controller supports only the winches in") as told:
        native_files(load_scenario(ROOT / "scenarios" / "winch_fmu.yaml"))
    assert "FMU" not in str(told.value)


def test_a_robot_is_refused(tmp_path):
    from click.testing import CliRunner

    robot = str(ROOT / "scenarios" / "robots" / "caroca.yaml")
    assert load_robot(robot).m == 8
    result = CliRunner().invoke(command, [robot, "--to", "native", "--out", str(tmp_path)])
    assert isinstance(result.exception, CdprError)
    assert "requires a scenario" in str(result.exception)


@dataclass
class Library:
    """The exported controller as a shared library."""

    loaded: ctypes.CDLL
    numbers: bytes
    memory: ctypes.Array
    m: int

    def begin(self, content=None):
        content = self.numbers if content is None else content
        return self.loaded.cdpr_begin(self.memory, content, ctypes.c_size_t(len(content)))

    def step(self, state, desired, tension, time=0.0):
        addresses = (array.ctypes.data_as(ctypes.c_void_p) for array in (state, desired, tension))
        return self.loaded.cdpr_step(self.memory, ctypes.c_double(time), *addresses)


def build(loaded, folder: Path) -> Library:
    """Compile the controller of a scenario."""
    compiler = tool("g++")
    write_native(loaded, folder)
    (folder / "controller.cpp").write_text(f'#define CDPR_IMPLEMENTATION\n#include "{HEADER}"\n')
    flags = ["-shared", "-fPIC", "-o", "controller.so"]
    subprocess.run([compiler, *FLAGS, *flags, "controller.cpp"], cwd=folder, check=True)
    memory = (ctypes.c_uint64 * 100_000)()
    library = ctypes.CDLL(str(folder / "controller.so"))
    return Library(library, (folder / NUMBERS).read_bytes(), memory, loaded.robot.m)


def replaced(content, word, value):
    """Return a file with another word and a checksum that fits."""
    changed = bytearray(content[:-8])
    changed[8 * word : 8 * word + 8] = value.to_bytes(8, "little")
    return bytes(changed) + zlib.crc32(changed).to_bytes(8, "little")


@pytest.mark.slow
def test_files_and_inputs_are_checked(tmp_path):
    library = build(scenario("caroca"), tmp_path)
    content = library.numbers
    state, desired, tension = np.zeros(13), np.zeros(19), np.full(library.m, 7.0)
    state[2:4] = desired[2:4] = 1.2, 1.0
    assert library.step(state, desired, tension) == NOT_READY
    assert library.begin(content[:24]) == BAD_SIZE
    assert library.begin(content[:-8]) == library.begin(content + bytes(8)) == BAD_SIZE
    assert library.begin(bytes(len(content))) == BAD_MAGIC
    assert library.begin(replaced(content, 1, 2)) == BAD_VERSION
    assert library.begin(replaced(content, 2, 1)) == OTHER_ROBOT
    rng = np.random.default_rng(1)
    for place in rng.integers(32, len(content), 100):
        damaged = bytearray(content)
        damaged[place] ^= 1 << int(rng.integers(8))
        assert library.begin(bytes(damaged)) == BAD_CHECKSUM
    assert library.step(state, desired, tension) == NOT_READY
    assert library.begin() == OK
    for array, place, value in ((state, 0, np.nan), (desired, 18, np.inf), (state, 3, 2.0), (desired, 3, 0.0)):
        wrong = array.copy()
        wrong[place] = value
        given = (wrong, desired) if array is state else (state, wrong)
        assert library.step(*given, tension) == BAD_INPUT
    assert library.step(state, desired, tension, np.inf) == BAD_INPUT
    assert (tension == 7.0).all()
    assert library.step(state, desired, tension) == OK
    assert (tension > 7.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("case", list(CASES))
def test_programs_reproduce_a_log_to_the_bit_without_allocation(case, tmp_path):
    for name in ("cmake", "g++", "gcc"):
        tool(name)
    loaded = scenario(*CASES[case])
    run = simulate(loaded)
    export(run, "csv", tmp_path / "run.csv")
    write_native(loaded, tmp_path / "robot")
    configure = ["cmake", "-S", str(EXAMPLE), "-B", "build", f"-DROBOT={tmp_path / 'robot'}"]
    subprocess.run(configure, cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "build"], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    for program in ("realtime", "realtime_c"):
        command = [f"build/{program}", "--fast", f"robot/{NUMBERS}", "run.csv", f"{program}.bin"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done
        told = dict(line.split() for line in done.stdout.splitlines())
        assert int(told["allocations_before"]) > 0  # those of the table: the counter works
        assert (told["allocations"], told["differences"], told["cycles"]) == ("0", "0", str(len(run.rows)))
        tensions = np.fromfile(tmp_path / f"{program}.bin").reshape(-1, loaded.robot.m)
        assert tensions.tobytes() == np.ascontiguousarray(run["tension"]).tobytes()
        assert int(told["status"]) == int((run["status"] != 0).any())
    assert (case == "replaced") == (run["status"] != 0).any()


WINCHES = {
    "servos": [],
    "ideal drives": ["robot.winch={type: position}", "controller.type=computed_torque"],
    "rates": ["robot.winch.type=velocity", "controller.type=computed_torque"],
    "mixed": [
        "robot.cables[1].winch={type: torque, drum_radius: 0.05, inertia: 0.002}",
        "controller.type=computed_torque",
    ],
}
UNITS = {"servos": "m", "ideal drives": "m", "rates": "m/s", "mixed": "m, N, m, m"}


@pytest.mark.parametrize("case", WINCHES)
def test_headers_contain_the_units_of_the_winches(case):
    text = native_files(scenario("camera_robot", WINCHES[case]))[HEADER].decode()
    assert f"/* Compute the commands (CDPR_CABLES), {UNITS[case]}, for a measured state" in text
    assert ("cdpr_measure" in text) == (case in ("ideal drives", "rates"))


@pytest.mark.slow
@pytest.mark.parametrize("case", WINCHES)
def test_commands_of_winches_are_those_of_a_run_to_the_bit(case, tmp_path):
    loaded = scenario("camera_robot", WINCHES[case])
    run = simulate(loaded)
    library = build(loaded, tmp_path)
    assert library.begin() == OK
    state = np.concatenate([run[each] for each in ("position", "orientation", "velocity", "angular_velocity")], axis=1)
    names = "position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration"
    desired = np.concatenate([run[f"desired_{each}"] for each in names], axis=1)
    command = np.zeros(loaded.robot.m)
    for k in range(len(run.rows)):
        if case in ("ideal drives", "rates"):
            lengths = np.ascontiguousarray(run.unstretched_length[k])
            assert library.loaded.cdpr_measure(library.memory, lengths.ctypes.data_as(ctypes.c_void_p)) == OK
        time = ctypes.c_double(run.time[k]).value
        assert library.step(state[k].copy(), desired[k].copy(), command, time) == OK
        np.testing.assert_array_equal(command, run.winch_command[k])
