"""Step-by-step simulations: the rows of `simulate`, branches to the bit, and one clear error for misuse."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from plants import installed

import cdpr
from cdpr.base.errors import ExitCode
from cdpr.log import recorder
from cdpr.plugins import Controller

BREAK = str(ROOT / "scenarios" / "cable_break.yaml")
CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = {"simulation.duration": 0.05}
EVENTS = [
    {"type": "cable_jam", "time": 0.02, "cable": 1, "detected_after": 0.004},
    {"type": "sine", "time": 0.01, "force": [50, 0, 0], "frequency": 20.0},
    {"type": "limits", "time": 0.03, "max": 900},
]
BUSY = {**SHORT, "events": EVENTS}
ENGINES = installed("reference", "mujoco", "bullet", "dart")


@pytest.mark.parametrize("controller", ["computed_torque", "static", "pid", "cable_length"])
@pytest.mark.usual("computed_torque", "pid")
def test_rows_are_those_of_simulate(controller):
    whole = cdpr.simulate(CAROCA, controller=controller, overrides=BUSY)
    with cdpr.Simulation(CAROCA, controller=controller, overrides=BUSY) as sim:
        while not sim.done:
            sim.step()
        run = sim.run()
    assert run.rows.tobytes() == whole.rows.tobytes()
    assert (run.status, run.events) == ("finished", whole.events)
    assert sim.run() is run


@pytest.mark.core
@pytest.mark.parametrize("backend", ENGINES)
def test_a_branch_continues_to_the_bit(backend):
    whole = cdpr.simulate(CAROCA, backend=backend, overrides=BUSY)
    with cdpr.Simulation(CAROCA, backend=backend, overrides=BUSY) as sim:
        sim.step(15)
        early = sim.snapshot()
        sim.until(0.026)
        late = sim.snapshot()
        sim.until(9.0)
        sim.restore(early)
        sim.step(20, tension=np.full(8, 200.0))
        sim.restore(late)
        assert sim.time == pytest.approx(0.026)
        sim.step(1000)
        assert sim.run().rows.tobytes() == whole.rows.tobytes()
        assert sim.run().events == whole.events


@pytest.mark.parametrize("controller", ["pid", "cable_length"])
def test_controllers_are_part_of_it(controller):
    """Both remember: without that the branch would end elsewhere."""
    whole = cdpr.simulate(CAROCA, controller=controller, overrides=SHORT)
    with cdpr.Simulation(CAROCA, controller=controller, overrides=SHORT) as sim:
        sim.step(20)
        here = sim.snapshot()
        sim.step(25, wrench=[300.0, 0, 900, 0, 0, 0])
        sim.restore(here)
        sim.step(50)
        assert sim.run().rows.tobytes() == whole.rows.tobytes()


def test_winches_are_part_of_it():
    path = str(ROOT / "scenarios" / "winch.yaml")
    whole = cdpr.simulate(path, overrides=SHORT)
    with cdpr.Simulation(path, overrides=SHORT) as sim:
        sim.step(20)
        here = sim.snapshot()
        sim.step(10)
        sim.restore(here)
        sim.step(50)
        assert sim.run().rows.tobytes() == whole.rows.tobytes()


def test_a_jam_is_reported_with_the_tension_of_its_own_branch():
    with cdpr.Simulation(CAROCA, overrides=BUSY) as sim:
        sim.step(5)
        here = sim.snapshot()
        sim.step(40, tension=np.full(8, 200.0))
        sim.restore(here)
        sim.step(50)
        told = sim.run().events
    assert told == cdpr.simulate(CAROCA, overrides=BUSY).events


@pytest.mark.core
def test_a_wrench_and_tensions_from_outside():
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.step(10, wrench=[10.0, 0, 700, 0, 0, 0])
        sim.step(5, wrench=[10.0, 0, 700, 0, 0, 0])
        sim.step(10, tension=[5e5, *[100.0] * 7])
        run = sim.run()
    np.testing.assert_allclose(run.wrench[:15], np.tile([10.0, 0, 700, 0, 0, 0], (15, 1)))
    clipped = [run.header.tension_max[0], *[100.0] * 7]
    np.testing.assert_array_equal(run.tension[15:25], np.tile(clipped, (10, 1)))
    outside = [(event.text, event.until) for event in run.events if event.kind == "outside"]
    assert outside == [
        ("the wrench was given from outside (15 samples)", 0.015),
        ("the tension was given from outside (10 samples)", 0.025),
    ]
    assert (run.status, len(run.rows)) == ("ended", 25)


def test_commands_take_the_place_of_commands_and_a_wrench_is_distributed_all_the_same():
    with cdpr.Simulation(CAROCA, controller="cable_length", overrides=SHORT) as sim:
        sim.step(1, tension=np.full(8, 123.0))
        np.testing.assert_array_equal(sim.tension, 123.0)
        sim.step(1, wrench=[0.0, 0, 700, 0, 0, 0])
        np.testing.assert_allclose(sim.run().wrench[1], [0, 0, 700, 0, 0, 0])


def test_a_broken_cable_stays_broken_whoever_decides():
    overrides = {**SHORT, "events": [{"type": "cable_break", "time": 0.01, "cable": 1}]}
    with cdpr.Simulation(CAROCA, overrides=overrides) as sim:
        sim.step(20, tension=np.full(8, 200.0))
        sim.step(20, wrench=[0.0, 0, 700, 0, 0, 0])
        tension = sim.run().tension
    assert (tension[:10, 0] == 200.0).all()
    assert (tension[10:, 0] == 0.0).all()


@pytest.mark.core
def test_observers_see_each_sample():
    seen = []
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.step(3)
        sim.observe(lambda row: seen.append(row.copy()))
        sim.step(100)
        run = sim.run()
    np.testing.assert_array_equal(seen, run.rows[3:])


def test_an_observer_that_raises_ends_the_run():
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.observe(lambda row: 1 / 0 if row[0] > 0.0095 else None)
        with pytest.raises(cdpr.CdprError, match=r"t = 0\.01 s: an observer raised ZeroDivisionError") as stop:
            sim.step(50)
    assert len(stop.value.run.rows) == 11


@pytest.mark.core
def test_an_early_end_is_raised_with_all_samples(tmp_path):
    overrides = {**SHORT, "solver.infeasible": "stop"}
    with cdpr.Simulation(CAROCA, overrides=overrides, out=tmp_path / "run") as sim:
        sim.step(10)
        with pytest.raises(cdpr.Infeasible) as stop:
            sim.step(5, wrench=[1e6, 0, 0, 0, 0, 0])
        assert sim.done
        assert sim.run() is stop.value.run
        with pytest.raises(cdpr.CdprError, match="the simulation is over: its run is infeasible"):
            sim.step()
    assert stop.value.exit_code == ExitCode.INFEASIBLE
    assert cdpr.load_run(tmp_path / "run").rows.tobytes() == stop.value.run.rows.tobytes()
    assert len(stop.value.run.rows) == 11


@pytest.mark.core
def test_a_log_is_that_of_simulate(tmp_path):
    cdpr.simulate(CAROCA, overrides=BUSY, out=tmp_path / "whole")
    with cdpr.Simulation(CAROCA, overrides=BUSY, out=tmp_path / "steps") as sim:
        for _ in range(10):
            sim.step(5)
    whole, steps = ((tmp_path / name / "log.mcap").read_bytes() for name in ("whole", "steps"))
    assert whole == steps


@pytest.mark.core
def test_reset_begins_anew():
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.step(30, wrench=[0.0, 0, 900, 0, 0, 0])
        sim.reset()
        assert (sim.time, sim.done) == (0.0, False)
        sim.step(100)
        assert sim.run().rows.tobytes() == cdpr.simulate(CAROCA, overrides=SHORT).rows.tobytes()
        state = sim.scenario.initial.state()
        state[:3] += 0.1
        sim.reset(state, seed=4)
        np.testing.assert_array_equal(sim.state, state)
        np.testing.assert_array_equal(sim.desired[:3], state[:3])
        sim.step(100)
        run = sim.run()
    assert run.header.seed == 4
    overrides = {**SHORT, "simulation.seed": 4, "initial.position": state[:3].tolist()}
    assert run.rows.tobytes() == cdpr.simulate(CAROCA, overrides=overrides).rows.tobytes()


MISUSE = {
    "step 0": (lambda sim: sim.step(0), "step: expected a whole number of steps, at least 1, got 0"),
    "step half": (lambda sim: sim.step(0.5), "whole number"),
    "both": (lambda sim: sim.step(wrench=[0] * 6, tension=[1] * 8), "not both"),
    "short wrench": (lambda sim: sim.step(wrench=[0, 0, 1]), r"wrench: the shape must be \(6,\)"),
    "nan": (lambda sim: sim.step(tension=[np.nan] * 8), "tension"),
    "infinite": (lambda sim: sim.step(wrench=np.array([0, 0, np.inf, 0, 0, 0])), "wrench: all numbers must be finite"),
    "masked": (lambda sim: sim.step(wrench=np.ma.masked_array(np.ones(6), [1, 0, 0, 0, 0, 0])), "wrench: .*masked"),
    "complex": (lambda sim: sim.step(tension=np.ones(8, dtype=complex)), "tension: expected real numbers"),
    "past": (lambda sim: sim.until(0.001), "until: expected at least the current time, 0.003 s"),
    "no time": (lambda sim: sim.until(np.nan), "until: expected at least the current time"),
    "words": (lambda sim: sim.until("noon"), "until: expected at least the current time"),
    "nothing": (lambda sim: sim.until(None), "until: expected at least the current time"),
    "observer": (lambda sim: sim.observe(3), "observe: expected a function"),
    "snapshot": (lambda sim: sim.restore("yesterday"), "restore: expected a snapshot of this simulation"),
    "state": (lambda sim: sim.reset([0.0] * 13), "quaternion is zero"),
}


@pytest.mark.parametrize("case", MISUSE)
def test_misuse_is_one_clear_error_and_costs_nothing(case):
    call, text = MISUSE[case]
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.step(3)
        with pytest.raises(cdpr.CdprError, match=text):
            call(sim)
        sim.step(100)
        assert sim.run().rows.tobytes() == cdpr.simulate(CAROCA, overrides=SHORT).rows.tobytes()


def test_a_snapshot_of_another_simulation_is_refused():
    with (
        cdpr.Simulation(CAROCA, overrides=SHORT) as one,
        cdpr.Simulation(CAROCA, overrides=SHORT) as two,
        pytest.raises(cdpr.CdprError, match="snapshot of this simulation"),
    ):
        two.restore(one.snapshot())


def test_logged_rows_are_kept(tmp_path):
    with cdpr.Simulation(CAROCA, overrides=SHORT, out=tmp_path / "run") as sim:
        sim.step()
        with pytest.raises(cdpr.CdprError, match="omit `out`"):
            sim.reset()
    assert len(cdpr.load_run(tmp_path / "run").rows) == 1


def test_samples_in_the_log_alone_are_not_made_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(recorder, "IN_MEMORY", 0)
    with cdpr.Simulation(CAROCA, overrides=SHORT, out=tmp_path / "run") as sim:
        here = sim.snapshot()
        sim.step()
        with pytest.raises(cdpr.CdprError, match=r"omit `out`, or set log\.step"):
            sim.restore(here)
        sim.step(100)
        assert sim.run().status == "finished"


class Forgetful(Controller):
    """Has no snapshots."""

    def control(self, time, state, desired, out):
        out[:] = [0, 0, 700, 0, 0, 0]


def test_a_plugin_without_snapshots_refuses():
    with cdpr.Simulation(CAROCA, controller=Forgetful, overrides=SHORT) as sim:
        sim.step(3)
        with pytest.raises(cdpr.PluginError, match="Forgetful cannot take snapshots"):
            sim.snapshot()
        sim.step(3)
        assert sim.run().status == "ended"


def test_an_interrupt_ends_it_as_interrupted(tmp_path):
    def interrupted():
        with cdpr.Simulation(CAROCA, overrides=SHORT, out=tmp_path / "run") as sim:
            sim.step(7)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    run = cdpr.load_run(tmp_path / "run")
    assert (run.status, len(run.rows)) == ("interrupted", 7)


@pytest.mark.slow
def test_the_line_of_the_readme():
    code = f"import cdpr; sim = cdpr.Simulation({BREAK!r}); sim.step(100); s = sim.snapshot(); print(sim.time)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "0.1\n"
    assert done.stderr == ""


def test_any_tree_of_branches():
    """Twenty leaves of one simulation, each as if nothing else had been tried."""
    rng = np.random.default_rng(7)
    with cdpr.Simulation(CAROCA, overrides=BUSY) as sim:
        known = [(sim.snapshot(), [])]
        for _ in range(20):
            snapshot, way = known[rng.integers(len(known))]
            sim.restore(snapshot)
            leg = int(rng.integers(1, 6)), [*rng.normal(0.0, 30.0, 2), 700.0, 0.0, 0.0, 0.0]
            sim.step(leg[0], wrench=leg[1])
            if not sim.done:
                known.append((sim.snapshot(), [*way, leg]))
        for snapshot, way in (known[-1], known[-2], known[len(known) // 2]):
            sim.restore(snapshot)
            sim.step()
            with cdpr.Simulation(CAROCA, overrides=BUSY) as straight:
                for count, wrench in way:
                    straight.step(count, wrench=wrench)
                straight.step()
                expected = straight.run().rows
            np.testing.assert_array_equal(sim.row, expected[-1])
        sim.restore(snapshot)
        sim.step()
        run = sim.run()
    assert run.rows.tobytes() == expected.tobytes()


@pytest.mark.parametrize("controller", ["computed_torque", "cable_length"])
def test_a_solver_that_follows_its_last_answer_follows_what_was_pulled(controller):
    """Tensions change by 20 N a step at most, whoever decided the step before, and in which branch."""
    overrides = {**SHORT, "solver": {"type": "qp", "change": 20.0}}
    columns = cdpr.simulate(CAROCA, overrides=SHORT).header.layout.columns
    pulled = np.linspace(300.0, 900.0, 8)
    rows = []
    with cdpr.Simulation(CAROCA, controller=controller, overrides=overrides) as sim:
        first = sim.snapshot()
        sim.step(5, wrench=[0.0, 0, 700, 0, 0, 0])
        sim.restore(first)
        sim.step(3, tension=pulled)
        wrench = sim.row[columns["wrench"]]
        here = sim.snapshot()
        for detour in (False, True):
            if detour:
                sim.step(9, wrench=[50.0, 0, 900, 0, 0, 0])
                sim.restore(here)
            sim.step(1, wrench=wrench)
            rows.append(sim.row)
            sim.restore(here)
    np.testing.assert_array_equal(*rows)
    change = np.abs(rows[0][columns["tension"]] - pulled).max()
    assert 10.0 < change <= 20.0 + 1e-9
    assert rows[0][columns["status"]] == 0.0


def test_external_commands_are_reported_up_to_the_stop():
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.step(1000, wrench=[0.0, 0, 700, 0, 0, 0])
        (event,) = [event for event in sim.run().events if event.kind == "outside"]
    assert event.text == "the wrench was given from outside (51 samples)"


def test_an_exception_of_the_user_ends_the_run_at_its_sample(tmp_path):
    def wrong():
        with cdpr.Simulation(CAROCA, overrides=SHORT, out=tmp_path / "run") as sim:
            sim.step(5)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        wrong()
    run = cdpr.load_run(tmp_path / "run")
    assert (run.status, len(run.rows)) == ("ended", 5)


def test_two_simulations_at_once_do_not_touch_each_other():
    with cdpr.Simulation(CAROCA, overrides=BUSY) as one, cdpr.Simulation(CAROCA, overrides=BUSY) as two:
        while not two.done:
            if one.time < 0.02:
                one.step(3, wrench=[0.0, 0, 700, 0, 0, 0])
            two.step()
        assert two.run().rows.tobytes() == cdpr.simulate(CAROCA, overrides=BUSY).rows.tobytes()


def test_a_diverged_run_reports_only_known_values():
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.push([1e12, 0, 0])
        with pytest.raises(cdpr.Diverged) as stop:
            sim.step(50)
        for call in (sim.step, sim.snapshot, lambda: sim.until(1.0), sim.stop):
            with pytest.raises(cdpr.CdprError, match="the simulation is over: its run is diverged"):
                call()
        assert sim.run() is stop.value.run


def test_the_desired_motion_is_made_once(monkeypatch):
    """Not for the loop, and again for the path that is drawn: a long spline takes its time."""
    scenario = cdpr.load_scenario(CAROCA, overrides={"simulation.duration": 0.01})
    made, kind = [], type(scenario.trajectory)
    make = kind.make
    monkeypatch.setattr(kind, "make", lambda motion: made.append(motion) or make(motion))
    cdpr.simulate(scenario)
    assert len(made) == 1
