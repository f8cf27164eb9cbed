"""Batches: each lane has the bits of a simulation of its own, whatever the others do."""

from __future__ import annotations

import numpy as np
import pytest
from batch_cases import BREAK, BRIEF, CAROCA, GAINS, WINCH, N, alone, assert_same, make
from conftest import ROOT

import cdpr
from cdpr.analysis.rollouts import block
from cdpr.analysis.rollouts import case as case_module


@pytest.fixture
def calls(monkeypatch):
    """Return how many cases were taken further in lanes, call by call."""
    found: list[int] = []
    forward = block.Block._forward

    def spy(self, cases, steps):
        found.append(len(cases))
        return forward(self, cases, steps)

    monkeypatch.setattr(block.Block, "_forward", spy)
    return found


def test_lanes_at_different_times(calls):
    batch = make()
    batch.step(50)
    batch.reset([3, 9])
    batch.step(20, mask=np.arange(N) != 5)
    batch.step(7)
    assert calls == [8, 3, 7, 3, 8, 3]
    steps = [77] * N
    steps[3] = steps[9] = 27
    steps[5] = 57
    for lane, count in enumerate(steps):
        assert_same(batch, lane, alone(count, **{"controller.kp": GAINS[lane]}))


def test_a_library_without_operations_in_lanes_steps_one_after_the_other(calls, monkeypatch):
    """That for plain x86-64 has none."""
    here = {name: each for name, each in block.operations().items() if not name.endswith("_lanes")}
    monkeypatch.setattr(block, "operations", lambda: here)
    batch = make(n=4)
    batch.step(20)
    assert calls == []
    for lane in range(4):
        assert_same(batch, lane, alone(20, **{"controller.kp": GAINS[lane]}))


def test_views_are_live_and_read_only():
    batch = make()
    rows, time, position = batch.rows, batch.time, batch.column("position")
    before = rows.copy()
    batch.step(3)
    assert rows is batch.rows
    assert (time == 0.003).all()
    assert not np.array_equal(rows, before)
    assert np.array_equal(position, rows[1:4])
    assert batch.column("time").shape == (1, N)
    for view in (rows, time, position, batch.samples, batch.active):
        with pytest.raises(ValueError, match="read-only"):
            view[...] = 0


def test_a_lane_ends_with_its_last_sample():
    batch = make(n=3)
    batch.step(399)
    assert batch.active.all()
    batch.step(5, mask=np.array([True, False, False]))
    assert batch.active.tolist() == [False, True, True]
    assert batch.samples.tolist() == [401, 399, 399]
    last = alone(400, **{"controller.kp": GAINS[0]})
    assert_same(batch, 0, last)
    batch.step(100)
    assert not batch.active.any()
    assert batch.errors == ("", "", "")
    before = batch.rows.copy()
    batch.step()
    assert np.array_equal(batch.rows, before)
    batch.reset()
    batch.step(2)
    assert_same(batch, 0, alone(2, **{"controller.kp": GAINS[0]}))


def test_a_state_of_a_simulation_continues_in_lanes():
    simulation = alone(60, BREAK)
    snapshot = simulation.snapshot()
    batch = make(BREAK, vary=None)
    batch.step(10)
    for lane in (2, 4, 8):
        batch.load(lane, snapshot)
    batch.load(5, batch.snapshot(4))
    assert batch.time[[2, 3, 4, 5]].tolist() == [0.06, 0.01, 0.06, 0.06]
    batch.step(70)
    simulation.step(70)
    for lane in (2, 4, 5, 8):
        assert_same(batch, lane, simulation)
    assert_same(batch, 3, alone(80, BREAK))


def test_a_lane_keeps_its_own_values_when_a_state_is_loaded():
    batch = make()
    batch.load(1, alone(30, **{"controller.kp": 100.0}).snapshot())
    batch.step(50)
    simulation = alone(30, **{"controller.kp": 100.0})
    simulation.set("controller.kp", float(GAINS[1]))
    simulation.step(50)
    assert_same(batch, 1, simulation)


LIVE = {
    "set": lambda simulation: simulation.set("controller.kp", 150.0),
    "push": lambda simulation: simulation.push(force=(5.0, 0.0, 3.0)),
    "brief push": lambda simulation: simulation.push(force=(5.0, 0.0, 3.0), duration=0.02),
    "released push": lambda simulation: (
        ((push := simulation.push(moment=(0.0, 0.3, 0.0))) and simulation.step(2)) or simulation.release(push)
    ),
    "target": lambda simulation: simulation.target(simulation.state[:3] + 0.02, duration=0.05),
    "cut": lambda simulation: simulation.cut(2, detected_after=0.02),
    "jam": lambda simulation: simulation.jam(3),
    "limits": lambda simulation: simulation.limits(min=8.0),
    "stop": lambda simulation: simulation.stop(1, stopping_time=0.03),
}


@pytest.mark.parametrize("name", LIVE)
def test_live_events_go_with_a_state(name):
    simulation = alone(30)
    LIVE[name](simulation)
    simulation.step(5)
    batch = make(vary=None, n=5)
    batch.step(10)
    for lane in (0, 2, 3):
        batch.load(lane, simulation.snapshot())
    batch.load(4, batch.snapshot(3))
    batch.step(30)
    simulation.step(30)
    for lane in (0, 2, 3, 4):
        assert_same(batch, lane, simulation)
    assert_same(batch, 1, alone(40))
    batch.load(2, batch.snapshot(1))
    batch.reset([0, 3])
    batch.step(10)
    assert_same(batch, 2, alone(50))
    assert_same(batch, 0, alone(10))
    assert_same(batch, 3, alone(10))
    batch.load(0, simulation.snapshot())
    if name != "stop":  # which ends external wrenches
        wrench = np.tile([0.0, 0.0, 26.0, 0.0, 0.0, 0.0], (5, 1))
        batch.step(3, wrench=wrench)
        simulation.step(3, wrench=wrench[0])
    assert_same(batch, 0, simulation)


def test_events_have_their_own_times():
    times = [0.05, 0.06, 0.05, 0.2, 0.3]
    with make(CAROCA.with_name("cable_break.yaml"), 5, vary={"events[0].time": times}) as batch:
        batch.step(70)
        batch.reset(1)
        batch.step(55)
        for lane, time in enumerate(times):
            steps = 55 if lane == 1 else 125
            assert_same(batch, lane, alone(steps, BREAK, **{"events[0].time": time}))


def test_a_lane_that_fails_fails_alone():
    vary = {
        "robot.platform.mass": [25.0, 25.0, -1.0, 1e4, 26.0, 27.0],
        "solver.infeasible": ["best_effort", "stop", "stop", "stop", "stop", "best_effort"],
    }
    batch = make(n=6, vary=vary)
    assert batch.active.tolist() == [True, True, False, True, True, True]
    assert "robot.platform.mass" in batch.errors[2]
    batch.step(40)
    assert batch.active.tolist() == [True, True, False, False, True, True]
    with pytest.raises(cdpr.Infeasible) as stop:
        alone(40, **{key: values[3] for key, values in vary.items()})
    assert batch.errors[3] == str(stop.value)
    for lane in (0, 1, 4, 5):
        assert_same(batch, lane, alone(40, **{key: values[lane] for key, values in vary.items()}))
    with pytest.raises(cdpr.CdprError, match="lane 2 did not start"):
        batch.snapshot(2)
    batch.load(3, batch.snapshot(0))  # as heavy as before: it fails at once again
    assert batch.active[3]
    batch.step(1)
    assert not batch.active[3]


def test_a_lane_that_diverges_is_as_far_as_it_was():
    given = {**BRIEF, "simulation.control_step": 0.01, "simulation.physics_step": 0.01, "robot.tension.max": 1e11}
    batch = make(n=4, vary={"controller.kp": [100.0, 1e6, 100.0, 90.0]}, overrides=given)
    batch.step(30)
    assert batch.active.tolist() == [True, False, True, True]
    with pytest.raises(cdpr.SimulationStopped) as stop:
        alone(40, **given, **{"controller.kp": 1e6})
    assert batch.errors[1] == str(stop.value)
    assert batch.errors[0] == ""


@pytest.mark.parametrize("solver", ["dykstra", "qp"])
def test_parts_without_lanes_step_alone(solver, calls):
    overrides = {**BRIEF, "solver.type": solver}
    batch = make(WINCH, 3, vary=None, overrides=overrides)
    batch.step(20)
    batch.reset(1)
    batch.step(5)
    assert calls == [3, 3]
    assert_same(batch, 0, alone(25, WINCH, **{"solver.type": solver}))
    assert_same(batch, 1, alone(5, WINCH, **{"solver.type": solver}))


def test_other_backends_step_alone():
    given = {**BRIEF, "simulation.backend": "mujoco"}
    pytest.importorskip("mujoco")
    batch = make(n=3, vary=None, overrides=given)
    batch.step(5)
    batch.reset(2)
    batch.step(5)
    assert_same(batch, 0, alone(10, **{"simulation.backend": "mujoco"}))
    assert_same(batch, 2, alone(5, **{"simulation.backend": "mujoco"}))


def test_cases_of_different_structure_do_not_share_lanes():
    vary = {"controller.type": ["static", "pid", "static", "static"]}
    batch = make(n=4, vary=vary)
    batch.step(20)
    for lane, kind in enumerate(vary["controller.type"]):
        assert_same(batch, lane, alone(20, **{"controller.type": kind}))


def test_reset_of_no_lanes_resets_none():
    batch = make(n=2)
    batch.step(3)
    batch.reset(np.flatnonzero(~batch.active))
    assert batch.samples.tolist() == [3, 3]


def test_a_lane_that_cannot_begin_again_ends(monkeypatch):
    batch = make(n=2)
    batch.step(3)
    batch._starts[1] = None  # as for a plugin without snapshots

    def fail(*_):
        raise cdpr.CdprError("no plant")

    monkeypatch.setattr(case_module, "build", fail)
    batch.reset(1)
    batch.step(2)
    assert (batch.active.tolist(), batch.samples.tolist()) == ([True, False], [5, 0])
    assert "no plant" in batch.errors[1]


@pytest.mark.parametrize("controller", ["computed_torque", "cable_length"])
def test_wrenches_from_outside(controller, calls):
    """One for each lane, held for the steps; lanes of a controller whose answers are commands go alone."""
    gravity = np.array([0.0, 0.0, 9.81 * 25.0, 0.0, 0.0, 0.0])
    wrenches = gravity * np.linspace(0.95, 1.05, 4)[:, None]
    own = {"controller.type": controller}
    batch = make(n=4, vary=None, overrides={**BRIEF, **own})
    batch.step(5, wrench=wrenches)
    batch.step(7)
    batch.step(3, wrench=wrenches[::-1], mask=np.array([True, True, True, False]))
    batch.step(1, wrench=wrenches)
    for lane in range(4):
        simulation = alone(0, **own)
        simulation.step(5, wrench=wrenches[lane])
        simulation.step(7)
        if lane < 3:
            simulation.step(3, wrench=wrenches[3 - lane])
        simulation.step(1, wrench=wrenches[lane])
        assert_same(batch, lane, simulation)
    if controller == "computed_torque":
        assert calls == [4, 4, 3, 4]
    with pytest.raises(cdpr.CdprError, match="wrench"):
        batch.step(wrench=wrenches[:2])
    with pytest.raises(cdpr.CdprError, match="finite"):
        batch.step(wrench=np.full((4, 6), np.nan))


HANGPRINTER = ROOT / "scenarios" / "hangprinter.yaml"
COMMANDS = {
    "tensions": ("tension", CAROCA, {}, np.linspace(300.0, 420.0, 8)),
    "tensions of a controller of tensions": ("tension", CAROCA, {"controller.type": "cable_length"}, np.full(8, 350.0)),
    "tensions as commands": ("command", CAROCA, {}, np.linspace(300.0, 420.0, 8)),
    "tensions of winches": ("tension", WINCH, {}, np.linspace(300.0, 420.0, 8)),
    "lengths": ("length", HANGPRINTER, {}, None),
    "lengths as commands": ("command", HANGPRINTER, {}, None),
    "rates": ("rate", HANGPRINTER, {"robot.winch.type": "velocity"}, np.array([0.01, -0.02, 0.0, 0.03])),
    "wrenches on lengths": ("wrench", HANGPRINTER, {}, np.array([0.0, 0.0, 12.0, 0.0, 0.0, 0.0])),
}


@pytest.mark.parametrize(("kind", "scenario", "changes", "values"), COMMANDS.values(), ids=COMMANDS)
def test_commands_from_outside_have_the_bits_of_single_simulations(kind, scenario, changes, values):
    """Given from the first sample on, several calls in a row, with other steps in between, and for some lanes."""
    overrides = {**BRIEF, **changes}
    batch = make(scenario, 4, vary=None, overrides=overrides)
    if values is None:  # lengths near those of the start
        first = alone(1, scenario, **changes)
        values = first.row[first.so_far().header.layout.columns["unstretched_length"]]
    given = values * np.linspace(0.995, 1.005, 4)[:, None]
    three = np.array([True, True, True, False])
    batch.step(1, **{kind: given})
    batch.step(1, **{kind: given[::-1]})
    batch.step(4, **{kind: given})
    batch.step(3)
    batch.step(2, **{kind: given}, mask=three)
    batch.step(2, **{kind: given[::-1]}, mask=three)
    batch.step(1, **{kind: given})
    batch.step(2)
    assert batch.errors == ("",) * 4
    for lane in range(4):
        simulation, own, other = alone(0, scenario, **changes), {kind: given[lane]}, {kind: given[3 - lane]}
        simulation.step(1, **own)
        simulation.step(1, **other)
        simulation.step(4, **own)
        simulation.step(3)
        if lane < 3:
            simulation.step(2, **own)
            simulation.step(2, **other)
        simulation.step(1, **own)
        simulation.step(2)
        assert_same(batch, lane, simulation)


def test_commands_of_caroca_stay_in_lanes(calls):
    batch = make(n=4, vary=None)
    given = np.full((4, 8), 350.0)
    for _ in range(3):
        batch.step(5, tension=given)
    assert calls == [4, 4, 4]


WRONG_COMMANDS = {
    "two": ({"wrench": np.zeros((2, 6)), "tension": np.ones((2, 4))}, "step: expected wrench or tension, not both"),
    "shape": ({"length": np.ones(4)}, r"length: the shape must be \(2, 4\)"),
    "not finite": ({"length": np.full((2, 4), np.nan)}, "length: .*finite"),
    "not taken": ({"rate": np.ones((2, 4))}, "step: lane 0: rate: the winches of this robot take"),
    "range": ({"length": [[1.0] * 4, [1.0, 1.0, -1.0, 1.0]]}, "step: lane 1: length: cable 'C': expected more than 0"),
}


@pytest.mark.parametrize("name", WRONG_COMMANDS)
def test_wrong_commands_change_nothing(name):
    given, text = WRONG_COMMANDS[name]
    batch = make(HANGPRINTER, 2, vary=None)
    with pytest.raises(cdpr.CdprError, match=text):
        batch.step(**given)
    batch.step(3)
    assert_same(batch, 0, alone(3, HANGPRINTER))


@pytest.mark.parametrize("wrong", [-1.0, np.nan])
def test_a_wrong_length_of_a_lane_that_is_not_stepped_is_ignored(wrong):
    batch = make(HANGPRINTER, 2, vary=None)
    batch.step(mask=[True, False], length=[[2.0] * 4, [wrong] * 4])
    assert batch.samples.tolist() == [1, 0]
    assert_same(batch, 0, _with_length(2.0))


def _with_length(value):
    simulation = alone(0, HANGPRINTER)
    simulation.step(1, length=[value] * 4)
    return simulation
