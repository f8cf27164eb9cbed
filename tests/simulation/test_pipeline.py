"""The order of a step: what is compiled and what is Python come to the same, and nothing is left out or done twice."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import re
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import CdprError, Infeasible
from cdpr.native.foreign import OPERATION, Foreign
from cdpr.plugins import CompiledSolver, Controller
from cdpr.simulation import pipeline
from cdpr.simulation.pipeline import Pipeline
from cdpr.tension.operations import Operation
from cdpr.tension.status import OK, Status
from cdpr_controllers import ComputedTorqueOptions
from cdpr_controllers.computed_torque import ComputedTorque
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

CAROCA = ROOT / "scenarios" / "caroca.yaml"
# By default one of each kind of step: events, loads, a belief, a guide, winches; the others among the slow tests.
KINDS = ("cable_break", "external_wrench", "believed", "planar", "winch")
SCENARIOS = [
    pytest.param(path, id=path.stem, marks=[] if path.stem in KINDS else [pytest.mark.slow])
    for path in sorted((ROOT / "scenarios").glob("*.yaml"))
]
ENGINES = ("mujoco", "bullet", "dart", "fmu")
SHORT = {"simulation.duration": 0.05, "trajectory.duration": 0.05}


@pytest.fixture
def by_python(monkeypatch):
    """Let Python do all acts."""

    def switch():
        monkeypatch.setattr(pipeline, "bound", lambda *given: None)

    return switch


def both_ways(path, folder, by_python, **options):
    """Run a scenario by compiled blocks and by Python; return the runs."""
    runs = []
    for way in ("blocks", "python"):
        runs.append(cdpr.simulate(path, out=folder / way, **options))
        by_python()
    return runs


def same(runs):
    blocks, python = runs
    np.testing.assert_array_equal(blocks.rows, python.rows)
    logs = [(Path(run.folder) / "log.mcap").read_bytes() for run in runs]
    assert logs[0] == logs[1]
    assert len(python.interpreted) > len(blocks.interpreted)


@pytest.mark.parametrize("path", SCENARIOS)
def test_blocks_and_python_give_the_same_bits(path, tmp_path, by_python):
    same(both_ways(path, tmp_path, by_python))


@pytest.mark.parametrize("policy", ["best_effort", "hold_tension"])
@pytest.mark.parametrize("solver", ["qp", "analytic_centre", "improved_closed_form"])
def test_samples_without_tensions_need_python_once(solver, policy, tmp_path, by_python, monkeypatch):
    """The first one binds what compiled code does from then on; warming up may have met one, too."""
    met = []
    meet = Operation.meet
    monkeypatch.setattr(Operation, "meet", lambda operation, code: (code and met.append(code)) or meet(operation, code))
    overrides = {"simulation.duration": 0.5, "solver.infeasible": policy}
    thesis = ROOT / "scenarios" / "thesis.yaml"
    run = cdpr.simulate(thesis, out=tmp_path / "one", solver=solver, overrides=overrides)
    assert np.count_nonzero(run.solver_status != Status.OK) > 100
    assert 0 < len(met) <= 3
    same(both_ways(thesis, tmp_path, by_python, solver=solver, overrides=overrides))


@pytest.mark.slow
@pytest.mark.parametrize("backend", ENGINES)
@pytest.mark.parametrize("path", SCENARIOS)
def test_blocks_and_python_give_the_same_bits_on_engines(path, backend, tmp_path, by_python):
    pytest.importorskip({"bullet": "pybullet", "dart": "dartpy", "fmu": "fmpy"}.get(backend, backend))
    try:
        scenario = cdpr.load_scenario(path, backend=backend)
        same(both_ways(scenario, tmp_path, by_python))
    except cdpr.PluginError as error:  # a plant that this backend does not know
        pytest.skip(str(error))


def foreign(call, timed=False):
    """Return a Python function as compiled code calls it: by its address."""

    def function(place, time):
        return int((call(time) if timed else call()) or 0)

    held = OPERATION(function)
    return Foreign(SimpleNamespace(address=ctypes.cast(held, ctypes.c_void_p).value, held=held))


class Counting:
    """Pipeline of two operations that decide and two that advance, one of each in Python, and what they noted."""

    def __init__(self, python, size=256):
        self.row, self.rows, self.seen = np.zeros(3), np.full((size, 3), np.nan), []
        self.on, self.code = True, np.zeros(1)
        operation = partial(self.python, python)
        self.pipeline = Pipeline(
            [
                operation("controller", add, 0, 1.0),
                Operation("solver", partial(self.note, "solve"), when=lambda: self.on),
            ],
            [
                operation("backend", add, 1, 10.0),
                operation("time", stamp, timed=True),
                Operation("events", self.happen, due=True),
            ],
            self.row,
            0.5,
        )
        self.pipeline.rows = self.rows

    def python(self, python, name, function, *arguments, timed=False):
        call = partial(function, self.row, *arguments)
        return Operation(name, call if python else foreign(call, timed), timed=timed)

    def note(self, what):
        self.seen.append((what, self.pipeline.count, self.pipeline.time))

    def happen(self):
        self.note("event")
        self.on = not self.on
        self.pipeline.due = self.pipeline.count + 3
        self.pipeline.refresh()


def add(row, place, value):
    row[place] += value


def stamp(row, time):
    row[2] = time


def answer(codes):
    return int(codes[0])


@pytest.mark.parametrize("python", [False, True])
def test_acts_are_done_in_their_order_and_when_they_are_due(python):
    it = Counting(python, size=4)
    it.pipeline.due = 2
    it.pipeline.run_until(7)
    k = np.arange(3.0, 7.0)
    np.testing.assert_array_equal(it.rows[[3, 0, 1, 2]], np.stack([k + 1, 10 * k, 0.5 * k], axis=1))
    assert it.seen == [
        ("solve", 0, 0.0),
        ("solve", 1, 0.5),
        ("event", 2, 1.0),
        ("event", 5, 2.5),
        ("solve", 5, 2.5),
        ("solve", 6, 3.0),
    ]
    assert (it.pipeline.count, it.pipeline.time, it.pipeline.due) == (7, 3.5, 8)
    it.pipeline.decide()
    assert (it.pipeline.count, it.pipeline.time, it.row[0]) == (8, 3.5, 8.0)
    it.pipeline.run_until(8)
    beside = Pipeline([], [], it.row, 0.5, it.pipeline)
    beside.decide()  # something else decides: neither controller nor solver
    it.pipeline.mark_complete()
    assert (it.pipeline.count, it.row[0], it.seen[-1][0]) == (9, 8.0, "event")
    place = it.pipeline.place
    it.pipeline.run_until(9)
    assert it.row[1] == 90.0
    it.pipeline.place = place
    it.pipeline.run_until(9)
    assert it.row[1] == 100.0


@pytest.mark.parametrize("python", [False, True])
def test_a_failed_requirement_skips_dependent_checks(python):
    codes, met, row = np.zeros(1), [], np.zeros(1)
    call = partial(answer, codes)
    solve = Operation("solver", call if python else foreign(call), met.append, skip=1)
    made = Pipeline([solve, Operation("distribution", foreign(partial(add, row, 0, 1.0)))], [], row, 1.0)
    made.rows = np.zeros((256, 1))
    made.run_until(2)
    codes[0] = 3
    made.run_until(3)
    assert met == [3]
    codes[0] = 0
    made.run_until(4)
    np.testing.assert_array_equal(made.rows[:4, 0], [1, 2, 2, 3])


@pytest.mark.parametrize("python", [False, True])
def test_samples_without_tensions_are_kept_with_their_reason(python):
    row, rows = np.zeros(2), np.full((256, 2), np.nan)

    def refuse(code):
        raise Infeasible("none")

    call = partial(answer, np.ones(1))
    made = Pipeline(
        [
            Operation("solver", call if python else foreign(call), refuse),
            Operation("geometry", foreign(partial(add, row, 0, 1.0))),
            Operation("geometry", foreign(partial(add, row, 1, 1.0)), telling=True),
        ],
        [],
        row,
        1.0,
    )
    made.rows = rows
    with pytest.raises(Infeasible):
        made.run_until(5)
    assert made.count == 1
    np.testing.assert_array_equal(rows[0], [0.0, 1.0])
    with pytest.raises(Infeasible):
        made.decide()
    assert made.count == 2


def test_overridden_methods_are_called():
    class Half(ComputedTorque):
        Options = ComputedTorqueOptions

        def control(self, time, state, desired, wrench):
            super().control(time, state, desired, wrench)
            wrench *= 0.5

    class Proud(MinimumNorm):
        Options = QpOptions
        asked = 0

        def solve(self, *given):
            Proud.asked += 1
            return super().solve(*given)

    whole = cdpr.simulate(CAROCA, overrides=SHORT)
    half = cdpr.simulate(CAROCA, controller=Half, overrides=SHORT)
    np.testing.assert_array_equal(half.wrench[0], 0.5 * whole.wrench[0])
    assert (whole.interpreted, half.interpreted) == ((), ("controller",))
    proud = cdpr.simulate(CAROCA, solver=Proud, overrides=SHORT)
    np.testing.assert_array_equal(proud.rows, whole.rows)
    assert Proud.asked > 50
    assert proud.interpreted == ("solver",)


def test_a_controller_of_python_leaves_the_rest_compiled(tmp_path):
    class Still(Controller):
        def control(self, time, state, desired, out):
            out[:] = [0.0, 0.0, 1500.0, 0.0, 0.0, 0.0]

    run = cdpr.simulate(CAROCA, controller=Still, overrides=SHORT, out=tmp_path / "run")
    assert run.interpreted == ("controller",)
    told = json.loads((tmp_path / "run" / "run.json").read_text())["loop"]
    assert told == {"blocks": False, "python": ["controller"]}
    assert cdpr.load_run(tmp_path / "run").interpreted == ("controller",)


def example(words):
    """Return the Python of the documentation that holds these words."""
    text = (ROOT / "docs" / "plugin_kernels.md").read_text()
    (code,) = (each for each in re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE) if words in each)
    return code


def test_the_controller_of_the_docs_is_compiled(tmp_path):
    pytest.importorskip("numba")
    code = example("class Lift")
    path = tmp_path / "lift.py"
    path.write_text(code)
    spec = importlib.util.spec_from_file_location("lift", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    run = cdpr.simulate(CAROCA, controller=module.Lift)
    assert (run.status, run.interpreted) == ("finished", ())
    assert np.abs(run.position_error).max() < 0.5  # nothing damps it


def test_third_party_solvers_are_included():
    """By the address of a function: its arguments are in a struct."""
    numba = pytest.importorskip("numba")
    types = numba.types

    @numba.cfunc(types.int32(types.CPointer(types.CPointer(types.float64)), types.float64))
    def middle(place, time):
        tension, chosen, work = place[4], place[7], place[8]
        for i in range(8):
            work[i] = chosen[0]
            tension[i] = work[i]
        return OK

    class Middle(CompiledSolver):
        def __init__(self, robot, options):
            super().__init__(robot, options, middle, parameters={"chosen": np.array([500.0])}, work=[(robot.m,)])

    run = cdpr.simulate(CAROCA, solver=Middle, overrides={**SHORT, "solver.infeasible": "hold_tension"})
    assert run.interpreted == ()
    assert (run.solver_status == Status.NOT_FOUND).all()  # it balances nothing
    robot = cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
    solver, tension = Middle(robot, None), np.zeros(8)
    assert solver.solve(np.zeros((6, 8)), np.zeros(6), np.zeros(8), np.ones(8), tension) == Status.OK
    assert (tension == 500.0).all()
    assert [array.shape for array in solver.work] == [(8,)]
    assert solver.solve(np.zeros((6, 7)), np.zeros(6), np.zeros(8), np.ones(8), tension) == Status.BAD_INPUT
    rows = cdpr.distribute(robot, np.tile(robot.home, (5000, 1)), solver=solver, jobs=2)
    assert (rows.status == Status.NOT_FOUND).all()


def test_a_table_narrower_than_a_row_is_refused():
    """Compiled code would write beyond it."""
    pipeline = Pipeline([], [], np.zeros(5), 1.0)
    pipeline.rows = np.zeros((256, 5))
    for rows in (np.zeros((256, 4)), np.zeros(256), np.zeros((256, 5), dtype=np.float32)):
        with pytest.raises(CdprError, match="expected a float64 table of at least 5 columns"):
            pipeline.rows = rows
