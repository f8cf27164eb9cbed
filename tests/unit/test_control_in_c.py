"""The C of each controller and solver that has some is its kernel, to the bit, whatever it is given."""

from __future__ import annotations

import ctypes
import dataclasses
import os
import shutil
import struct
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, crossed_box, make_robot

from cdpr import load_scenario
from cdpr.errors import CdprError
from cdpr.fmu.export import Controller as ExportedController
from cdpr.fmu.export import fmu_bytes
from cdpr.fmu.export.library import library, sources
from cdpr.plugins import Controller
from cdpr.plugins.in_c import c_file, law_in_c, solve_in_c, with_c
from cdpr.plugins.registry import registry
from cdpr.simulation.exported import control_of

pytestmark = pytest.mark.skipif(shutil.which(os.environ.get("CC") or "cc") is None, reason="no C compiler")

FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off", "-Wall", "-Wextra", "-Wshadow", "-Werror")
DOUBLE, ROW = ctypes.c_double, ctypes.POINTER(ctypes.c_double)
LAWS, SOLVERS = with_c(registry(), "controller"), with_c(registry(), "solver")
GRAVITY = np.array([0.2, -0.1, -9.81])
HOSTILE = [0.0, -1.0, 1e-300, 1e200, np.inf, np.nan]


class Known(ctypes.Structure):
    _fields_ = [("numbers", ROW), ("inertial", ROW), ("gravity", ROW), ("step", DOUBLE), ("delivered", ctypes.c_bool)]


class Problem(ctypes.Structure):
    _fields_ = [("n", ctypes.c_size_t), ("m", ctypes.c_size_t)] + [(x, ROW) for x in ("W", "wrench", "low", "high")]


def pointer(array):
    return array.ctypes.data_as(ROW)


def factory(role, name):
    return registry().get(role, name).info.factory.split(":")[0]


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """All laws and solvers in one library, compiled without a warning."""
    own = {name: sources()[name] for name in ("laws.h", "laws.c", "tension.c", "vector.h")}
    for role, names in (("controller", LAWS), ("solver", SOLVERS)):
        for name in names:
            path = c_file(factory(role, name))
            own[path.name] = path.read_bytes()
    place = tmp_path_factory.mktemp("laws") / "laws.so"
    place.write_bytes(library(own, FLAGS))
    return ctypes.CDLL(str(place))


def bits(values):
    return [b"nan" if np.isnan(value) else struct.pack("d", value + 0.0) for value in np.ravel(values)]


def given(rng, size, k):
    """Numbers of usual sizes, and some hostile ones among them."""
    row = rng.normal(size=size) * 10.0 ** rng.uniform(-2, 2)
    if k % 4 == 3:
        row[rng.integers(size, size=2)] = np.array(HOSTILE)[rng.integers(len(HOSTILE), size=2)]
    return row


@pytest.mark.parametrize("name", LAWS)
def test_the_c_of_a_controller_is_its_kernel_to_the_bit(name, compiled):
    rng = np.random.default_rng(1)
    robot = make_robot(crossed_box(rng, 8))
    entry, step = registry().get("controller", name), 0.002
    options = {"kp": [100, 90, 80, 70, 60, 50], "kd": 20}
    if name == "pid":
        options |= {"ki": 30, "integral_limit": 0.5}
    controller = entry.make(robot, GRAVITY, step, entry.read_options(options))
    path = law_in_c(controller, name, registry())
    law = getattr(compiled, f"{path.stem}_law")
    law.restype = None
    report, memory, count = np.zeros(4), np.zeros(16), 0
    controller.connect(report)
    controller.reset()
    numbers = np.concatenate([np.ravel(value) for value in controller.numbers_in_c().values()])
    inertial, gravity = robot.inertial.copy(), GRAVITY.copy()
    for k in range(800):
        state, desired = given(rng, 13, k), given(rng, 19, k)
        for row in (state, desired):
            row[3:7] /= np.linalg.norm(row[3:7]) if k % 4 != 3 else 1.0
        if k % 5 == 0:
            desired[3:7] = state[3:7]  # no error at all
        report[0] = float(rng.integers(2))
        expected, found = np.zeros(6), np.zeros(6)
        controller.control(0.0, state, desired, expected)
        known = Known(pointer(numbers), pointer(inertial), pointer(gravity), step, bool(report[0] == 0.0))
        law(ctypes.byref(known), pointer(memory), pointer(state), pointer(desired), pointer(found))
        assert bits(found) == bits(expected)
        count += np.isfinite(found).all()
        if not np.isfinite(found).all():  # what it remembers is no number any more
            controller.reset()
            memory[:] = 0.0
    assert count > 500


def problems(rng):
    """Wrench matrices of robots, of lower rank, with locked cables, of too little room, and hostile ones."""
    for k in range(600):
        n, m = int(rng.integers(1, 7)), int(rng.integers(1, 10))
        W = rng.normal(size=(n, m))
        if k % 5 == 1 and n > 1:
            W[-1] = W[0]
        low, high = rng.uniform(0.0, 50.0, m), rng.uniform(60.0, 400.0, m)
        if k % 4 == 1:
            high[: m // 3] = low[: m // 3]
        wrench = W @ rng.uniform(low, high) if k % 3 else rng.normal(size=n) * 500.0
        if k % 7 == 6:
            wrench[rng.integers(n)] = HOSTILE[rng.integers(len(HOSTILE))]
        if k % 11 == 10:
            high[rng.integers(m)] = np.inf
        yield n, m, np.ascontiguousarray(W), wrench, low, high


@pytest.mark.parametrize("name", SOLVERS)
def test_the_c_of_a_solver_is_its_kernel_to_the_bit(name, compiled):
    entry = registry().get("solver", name)
    compiled.work_size.restype = ctypes.c_size_t
    compiled.work_size.argtypes = [ctypes.c_size_t, ctypes.c_size_t]
    statuses, robots = set(), {}
    for n, m, W, wrench, low, high in problems(np.random.default_rng(2)):
        if (n, m) not in robots:
            robot = partial(type, "Sized", (), {"n": n, "m": m})()
            robots[n, m] = entry.make(robot, entry.read_options({}))
        solver = robots[n, m]
        solve = getattr(compiled, f"{solve_in_c(solver, name, registry()).stem}_solve")
        expected, found = np.zeros(m), np.zeros(m)
        status = solver.solve(W, wrench, low, high, expected)
        work = np.full(compiled.work_size(n, m), np.nan)  # it reads nothing that it has not written
        problem = Problem(n, m, pointer(W), pointer(wrench), pointer(low), pointer(high))
        assert solve(ctypes.byref(problem), pointer(found), pointer(work)) == status
        if status == 0:
            assert bits(found) == bits(expected)
        statuses.add(status)
    assert {0, 1, 4} <= statuses


def test_there_are_some_and_their_files_are_theirs():
    assert {"computed_torque", "static", "pid"} <= set(LAWS)
    assert {"closed_form", "pseudo_inverse"} <= set(SOLVERS)
    files = {c_file(factory(*each)) for each in [*(("controller", x) for x in LAWS), *(("solver", x) for x in SOLVERS)]}
    folders = (ROOT / "cdpr_controllers", ROOT / "cdpr_solvers")
    assert files == {path for folder in folders for path in Path(folder).rglob("*.c")}
    assert not {path.name for path in files} & set(sources())


def test_a_file_of_a_name_that_is_taken_is_refused(tmp_path):
    """Of a plugin whose module is called as one of our C files."""
    loaded = load_scenario(ROOT / "scenarios/planar.yaml", overrides=["solver.type=closed_form"])
    taken = tmp_path / "winch.c"
    taken.write_text("")
    with pytest.raises(CdprError, match=r"another winch\.c"):
        fmu_bytes(ExportedController(dataclasses.replace(control_of(loaded), law=taken)), 3)


def test_another_law_of_a_derived_class_is_not_taken_for_that_in_c():
    entry = registry().get("controller", "computed_torque")
    robot = make_robot(crossed_box(np.random.default_rng(1), 8))
    kind = entry.load()

    class Other(kind):
        def control(self, time, state, desired, out):
            out[:] = 1.0

    for made in (Other, kind):
        controller = made(robot, GRAVITY, 0.001, entry.read_options({"kp": 1, "kd": 1}))
        assert isinstance(controller, Controller)
        if made is kind:
            assert law_in_c(controller, "computed_torque", registry()).name == "computed_torque.c"
            controller.control = lambda *_: None
        with pytest.raises(CdprError, match=r"these can: .*computed_torque"):
            law_in_c(controller, "other", registry())
