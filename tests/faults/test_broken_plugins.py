"""Broken plugins in a whole run: named in one line, nothing lost, nothing false believed."""

from __future__ import annotations

import json
import sys
import types

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import PluginError
from cdpr.plugins import Backend, Controller, PluginInfo, PluginOptions, TensionSolver
from cdpr.plugins.registry import Registered, registry
from cdpr.tension import Status
from cdpr_backends.reference import ReferenceBackend
from cdpr_controllers import ComputedTorqueOptions
from cdpr_controllers.computed_torque import ComputedTorque
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

pytestmark = pytest.mark.core

CAROCA = ROOT / "scenarios" / "caroca.yaml"
AT = 20  # the call in which some of them break; the first is the warm-up


class Probe:
    """Counts its calls, and breaks in one of them."""

    calls = 0

    @property
    def now(self) -> bool:
        self.calls += 1
        return self.calls == AT


class LateSolver(MinimumNorm, Probe):
    def solve(self, W, wrench, t_min, t_max, tension):
        if self.now:
            raise ZeroDivisionError("oops")
        return super().solve(W, wrench, t_min, t_max, tension)


class ExitingSolver(MinimumNorm, Probe):
    def solve(self, W, wrench, t_min, t_max, tension):
        if self.now:
            sys.exit(3)
        return super().solve(W, wrench, t_min, t_max, tension)


class EarlySolver(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        raise ValueError("boo")


class ReturningSolver(TensionSolver):
    def solve(self, W, wrench, t_min, t_max, tension):
        tension = np.linalg.pinv(W) @ wrench  # noqa: F841 - a new array: the caller's keeps its values
        return Status.OK


class IdleSolver(TensionSolver):
    """Finds nothing within its limit of iterations."""

    def solve(self, W, wrench, t_min, t_max, tension):
        return Status.NOT_FOUND


class ArraySolver(TensionSolver):
    def solve(self, W, wrench, t_min, t_max, tension):
        return np.linalg.pinv(W) @ wrench


class CheatingSolver(MinimumNorm):
    """Would make any answer right."""

    def solve(self, W, wrench, t_min, t_max, tension):
        W *= 0.0
        wrench *= 0.0
        tension[:] = t_min
        return Status.OK


class ReturningController(Controller):
    def control(self, time, state, desired, wrench):
        return np.zeros(6)


class CheatingController(ComputedTorque):
    def control(self, time, state, desired, wrench):
        desired[:3] = state[:3]


class LateController(ComputedTorque, Probe):
    def control(self, time, state, desired, wrench):
        if self.now:
            raise RuntimeError("no law")
        super().control(time, state, desired, wrench)


class BackendThatCannotReset(ReferenceBackend):
    def reset(self, state):
        raise OSError("no licence")


class LateBackend(ReferenceBackend, Probe):
    def step(self, n):
        if self.now:
            raise RuntimeError("lost the plant")
        super().step(n)


class BackendThatCannotClose(ReferenceBackend):
    def close(self):
        raise RuntimeError("stuck")


def simulate(role, kind, monkeypatch, tmp_path):
    module = types.ModuleType("broken_plugin")
    module.Broken = kind
    monkeypatch.setitem(sys.modules, "broken_plugin", module)
    options = {"options": {"controller": ComputedTorqueOptions, "solver": QpOptions}.get(role, PluginOptions)}
    info = PluginInfo("broken", "broken_plugin:Broken", "breaks", **options)
    monkeypatch.setitem(registry().plugins[role], "broken", Registered(role, info, "broken-plugin", "1"))
    return cdpr.simulate(CAROCA, **{role: "broken"}, overrides={"simulation.duration": 0.1}, out=tmp_path / "run")


@pytest.mark.parametrize(
    ("role", "kind", "text", "samples"),
    [
        ("solver", LateSolver, r"t = 0.018 s: solver 'broken' raised ZeroDivisionError: oops", AT - 2),
        ("solver", ExitingSolver, r"t = 0.018 s: solver 'broken' raised SystemExit: 3", AT - 2),
        ("solver", EarlySolver, r"solver 'broken' raised ValueError: boo", 0),
        ("solver", ReturningSolver, r"solver 'broken' wrote no tensions", 0),
        ("solver", IdleSolver, r"solver 'broken' returned NOT_FOUND for the initial state, without tensions: raise", 0),
        ("solver", ArraySolver, r"solver 'broken' returned an array, which is not a .*Status: `solve` writes into", 0),
        ("solver", CheatingSolver, r"solver 'broken' raised ValueError: .*read-only", 0),
        ("controller", ReturningController, r"the controller wrote no wrench", 0),
        ("controller", CheatingController, r"ValueError: .*read-only in control \(test_broken_plugins", 0),
        ("controller", LateController, r"t = 0.018 s: a plugin raised RuntimeError: no law in control", AT - 2),
        ("backend", BackendThatCannotReset, r"a plugin raised OSError: no licence in reset", 0),
        ("backend", LateBackend, r"a plugin raised RuntimeError: lost the plant in step", AT - 1),
    ],
)
def test_it_is_named_and_what_came_before_is_kept(role, kind, text, samples, monkeypatch, tmp_path):
    with pytest.raises(PluginError, match=text) as caught:
        simulate(role, kind, monkeypatch, tmp_path)
    run = caught.value.run
    assert run.status == "failed"
    assert len(run.rows) == samples
    if not samples:  # it did not begin: the folder is free for the next try
        assert run.folder is None
        assert list((tmp_path / "run").iterdir()) == []
        return
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert told["status"] == "failed"
    assert told["message"] == str(caught.value)
    np.testing.assert_array_equal(cdpr.load_run(tmp_path / "run").rows, run.rows)


def test_a_backend_that_cannot_close_loses_nothing(monkeypatch, tmp_path):
    run = simulate("backend", BackendThatCannotClose, monkeypatch, tmp_path)
    assert run.status == "finished"
    assert "stuck" in run.events[-1].text
    np.testing.assert_array_equal(cdpr.load_run(tmp_path / "run").rows, run.rows)


class Counting(ReferenceBackend):
    made = closed = 0

    def __init__(self, *arguments):
        super().__init__(*arguments)
        Counting.made += 1

    def close(self):
        Counting.closed += 1


def test_every_backend_is_closed(monkeypatch, tmp_path):
    simulate("backend", Counting, monkeypatch, tmp_path)
    assert Counting.made == Counting.closed == 1


class Stateful(ComputedTorque):
    """Forgets on reset; a warm-up that left a trace would shift its wrench."""

    calls = 0

    def control(self, time, state, desired, wrench):
        super().control(time, state, desired, wrench)
        wrench[2] += 0.01 * self.calls
        self.calls += 1

    def reset(self):
        self.calls = 0


def test_the_warm_up_leaves_no_trace(monkeypatch, tmp_path):
    run = simulate("controller", Stateful, monkeypatch, tmp_path)
    plain = cdpr.simulate(CAROCA, overrides={"simulation.duration": 0.1})
    np.testing.assert_array_equal(run.rows[0], plain.rows[0])
    assert run.wrench[1, 2] > plain.wrench[1, 2]


def test_an_interrupt_keeps_the_run_and_stays_an_interrupt(tmp_path):
    """So that a loop over many runs, which catches CdprError, can be stopped."""

    def progress(done, total):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        cdpr.simulate(CAROCA, out=tmp_path / "run", progress=progress)
    assert caught.value.run.status == "interrupted"
    assert len(cdpr.load_run(tmp_path / "run").rows) == len(caught.value.run.rows) == 256


def test_stop_keeps_the_violating_sample():
    with pytest.raises(cdpr.Infeasible) as caught:
        cdpr.simulate(CAROCA, overrides={"robot.tension.max": 200, "solver.infeasible": "stop"})
    run = caught.value.run
    assert len(run.rows) == 1
    assert run.summary()["infeasible_steps"] == 1
    assert run.residual[0] > 0.0


assert issubclass(Counting, Backend)
