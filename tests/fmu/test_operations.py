"""Sources of compiled operations in exported FMUs, and a solver whose operation was compiled elsewhere."""

from __future__ import annotations

import ctypes
import subprocess

import numpy as np
import pytest
from conftest import ROOT
from fmu.cases import quick_compiler, write
from fmu.driver import Driver

from cdpr import load_scenario
from cdpr.base.errors import CdprError
from cdpr.fmu.export import Controller
from cdpr.native import get_include
from cdpr.native.bind import bind
from cdpr.native.entries import entry_of, header_text, headers_of, table
from cdpr.native.exported_pipeline import operation_name
from cdpr.native.operations import operations
from cdpr.native.own import Own
from cdpr.plugins import CompiledSolver
from cdpr.simulation.exported import control_of

MINE = """
#pragma once
#include <cdpr/field.hpp>

namespace mine {

struct Problem {
    const double *matrix, *wrench, *tension_min, *tension_max;
    double* tension;
    int64_t n, m;
    double share;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), tension(m), n, m, share";
};

inline int solve(Problem& p) {
    for (int64_t i = 0; i < p.m; i++) p.tension[i] = p.tension_min[i] + p.share * (p.tension_max[i] - p.tension_min[i]);
    return 0;
}

}  // namespace mine
"""
DOOR = """
#include "mine.hpp"
extern "C" int door(void* place, double) { return mine::solve(*static_cast<mine::Problem*>(place)); }
"""


def test_each_operation_is_found_in_a_header_of_its_table():
    for name in operations():
        header, arguments = entry_of(name)
        assert header_text(header)
        assert "," in arguments
    assert entry_of("minimum_norm").header == "cdpr_solvers/qp.hpp"
    assert entry_of("pid") == ("cdpr_controllers/pid.hpp", "PidControl<double>, pid<double>")


def test_an_unknown_operation_is_refused():
    with pytest.raises(CdprError, match="operation 'nothing'"):
        entry_of("nothing")


def test_headers_come_with_those_that_they_include():
    found = headers_of([table(["pid"]).decode()])
    assert {"cdpr/entry.hpp", "cdpr/vector.hpp", "cdpr/table.h", "cdpr_controllers/pid.hpp"} <= set(found)
    assert "cdpr_solvers/qp.hpp" not in found
    for text in found.values():
        assert set(headers_of([text.decode()])) <= set(found)


def test_bound_operations_have_names():
    left, right = np.eye(3), np.ones((3, 3))
    assert operation_name(bind("cross_products", left=left, right=right, product=np.empty((3, 3)))) == "cross_products"


class Mine(CompiledSolver):
    """All tensions are the same share of their limits."""

    door = 0

    def __init__(self, robot, options):
        super().__init__(robot, options, self.door, parameters={"share": 0.25})


@pytest.mark.slow  # compiles the whole control
def test_an_operation_that_was_compiled_elsewhere(tmp_path, monkeypatch):
    header = tmp_path / "mine.hpp"
    header.write_text(MINE)
    (tmp_path / "door.cpp").write_text(DOOR)
    command = ["c++", "-std=c++17", "-shared", "-fPIC", f"-I{get_include()}", "-o", "door.so", "door.cpp"]
    subprocess.run(command, cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "door.so"))
    monkeypatch.setattr(Mine, "door", ctypes.cast(library.door, ctypes.c_void_p).value)
    loaded = load_scenario(ROOT / "scenarios" / "planar.yaml", overrides=["solver.infeasible=hold_tension"])
    control = exported(loaded, monkeypatch)
    with pytest.raises(CdprError, match="give the plugin the attribute `source`"):
        control()
    monkeypatch.setattr(Mine, "source", Own(header, "mine::Problem, mine::solve"))
    made = control()
    assert made.sources()["own/mine.hpp"] == MINE.encode()
    with Driver(write(Controller(made), 3, tmp_path)) as driver:
        driver.step(0.0, 0.001)  # its answer balances nothing, so the tensions before are held, within the limits
        assert driver.get("command").tolist() == made.robot.tension_min.tolist()


def exported(loaded, monkeypatch):
    """Return a function that exports a scenario with that solver in place of its own."""
    from cdpr.simulation import exported as module

    chosen = module.chosen_plugins(loaded)

    class Entry:
        info = chosen["solver"].info

        @staticmethod
        def make(robot, options):
            return Mine(robot, options)

    monkeypatch.setattr(module, "chosen_plugins", lambda _: {**chosen, "solver": Entry()})
    return lambda: control_of(loaded)


@pytest.mark.slow
def test_another_controller_compiles_its_own_operations_alone(tmp_path, monkeypatch):
    """Objects of the plant come from the cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    log = tmp_path / "calls"
    monkeypatch.setenv("CXX", quick_compiler(tmp_path, f'echo "$@" >> {log}'))
    calls = []
    for controller in ("computed_torque", "pid"):
        loaded = load_scenario(ROOT / "scenarios" / "planar.yaml", overrides=[f"controller.type={controller}"])
        write(Controller(control_of(loaded)), 3, tmp_path)
        calls.append(sum(" -c " in line for line in log.read_text().splitlines()))
    assert calls[0] > 5
    assert calls[1] - calls[0] in (1, 2)  # its operations, and what calls them
