"""Logs, files, branches, observers and threads of a simulation with external actions."""

from __future__ import annotations

import copy
import json
import pickle
import threading

import pytest
from live_cases import CAROCA, PLANNED, QUIET, quiet, simulated

import cdpr
from cdpr.analysis.compare.job import compare_scenario
from cdpr.analysis.study import load_study, run_study
from cdpr.plugins import Controller


def test_a_branch_of_a_log_continues_in_another_folder(tmp_path):
    with cdpr.Simulation(CAROCA, overrides={**QUIET, **PLANNED}, out=tmp_path / "run") as sim:
        sim.step(5)
        here = sim.snapshot()
        sim.step(3, wrench=[0, 0, 1400, 0, 0, 0])
        sim.push([40, 0, 0])
        sim.step(3)
        sim.restore(here)
        first = cdpr.load_run(tmp_path / "run")
        assert (first.status, len(first.rows)) == ("ended", 11)
        sim.cut(2)
        sim.step(4)
        sim.restore(here, out=tmp_path / "other")
        sim.step(100)
        run = sim.run()
    whole = simulated(**PLANNED)
    assert run.rows.tobytes() == whole.rows.tobytes() == cdpr.load_run(tmp_path / "other").rows.tobytes()
    assert (tmp_path / "run" / "session.yaml").exists()
    assert not (tmp_path / "other" / "session.yaml").exists()
    second = cdpr.load_run(tmp_path / "run-2")
    assert (second.status, len(second.rows), second.folder) == ("ended", 9, str(tmp_path / "run-2"))
    repeated = cdpr.simulate(tmp_path / "run-2" / "session.yaml")
    assert repeated.rows.tobytes() == second.rows.tobytes()
    assert second.header.broken == repeated.header.broken != ()
    branches = [
        json.loads((tmp_path / name / "run.json").read_text()).get("branch") for name in ("run", "run-2", "other")
    ]
    assert branches == [
        None,
        {"folder": str(tmp_path / "run"), "time": 0.005},
        {"folder": str(tmp_path / "run-2"), "time": 0.005},
    ]


def test_a_thinned_log_counts_what_was_done(tmp_path):
    with cdpr.Simulation(CAROCA, overrides={**QUIET, "log.step": 0.01}, out=tmp_path / "run") as sim:
        sim.step(5)
        sim.cut(2)
        sim.step(10)
        sim.jam(3)
        sim.step(100)
        run = sim.run()
    logged, again = cdpr.load_run(tmp_path / "run"), cdpr.simulate(tmp_path / "run" / "session.yaml")
    assert run.rows.tobytes() == logged.rows.tobytes() == again.rows.tobytes()
    assert run.events == again.events
    figures = [each.summary()["tension_N"] for each in (run, logged, again)]
    assert figures[0] == figures[1] == figures[2]


def test_a_finished_log_stays_finished_when_a_branch_leaves_it(tmp_path):
    with cdpr.Simulation(CAROCA, overrides=QUIET, out=tmp_path / "run") as sim:
        sim.step(10)
        here = sim.snapshot()
        sim.step(100)
        sim.restore(here)
        sim.step(3)
    assert [cdpr.load_run(tmp_path / name).status for name in ("run", "run-2")] == ["finished", "ended"]


def test_a_simulation_cannot_be_copied():
    with quiet() as sim:
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(cdpr.CdprError, match="cannot be copied or pickled"):
                copied(sim)


@pytest.mark.parametrize(
    "call",
    [
        lambda: cdpr.simulate(CAROCA, out=5),
        lambda: cdpr.load_run(None),
        lambda: load_study(None),
        lambda: compare_scenario(CAROCA, out=5),
        lambda: run_study(None, 5),
    ],
)
def test_invalid_names_are_reported(call):
    with pytest.raises(cdpr.CdprError, match=r"expected .*, (got|not) (5|null|a NoneType)"):
        call()


def test_a_branch_that_has_no_folder_changes_nothing(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").write_text("")
    with cdpr.Simulation(CAROCA, overrides=QUIET, out=tmp_path / "run") as sim:
        here = sim.snapshot()
        sim.step(5)
        for out in (tmp_path / "full", 5):
            with pytest.raises(cdpr.OutputError):
                sim.restore(here, out=out)
        sim.step(100)
    assert cdpr.load_run(tmp_path / "run").rows.tobytes() == simulated().rows.tobytes()


def test_observers_only_look_on(tmp_path):
    with quiet() as sim:
        sim.observe(lambda row: sim.push([1, 0, 0]))
        with pytest.raises(
            cdpr.CdprError, match=r"an observer raised CdprError: push: the simulation is executing a step"
        ):
            sim.step(3)
        assert (sim.run().status, len(sim.run().rows)) == ("failed", 1)


def test_threads_wait_for_each_other():
    entered, go_on = threading.Event(), threading.Event()
    with quiet() as sim:

        def look(row):
            entered.set()
            go_on.wait(10.0)

        sim.observe(look)
        thread = threading.Thread(target=sim.step, args=(2,))
        thread.start()
        assert entered.wait(10.0)
        for call in (sim.step, lambda: sim.push([1, 0, 0]), sim.snapshot, sim.run, sim.reset, lambda: sim.until(1)):
            with pytest.raises(cdpr.CdprError, match="executing a step"):
                call()
        go_on.set()
        thread.join()
        assert sim.time == 0.002


class Stubborn(Controller):
    """declares what it does not take"""

    from cdpr_controllers import StaticOptions as Options

    changeable = ("kp",)

    def control(self, time, state, desired, out):
        out[:] = [0, 0, 1500, 0, 0, 0]


def test_a_plugin_that_does_not_take_what_it_declares():
    with cdpr.Simulation(CAROCA, controller=Stubborn, overrides=QUIET) as sim:
        sim.step(3)
        with pytest.raises(
            cdpr.PluginError, match=r"^set: controller\.kp: Stubborn declares changeable options but has no method"
        ):
            sim.set("controller.kp", 3)
        sim.step(3)
        assert sim.run().status == "ended"


def test_a_saved_scenario_finds_its_files_from_elsewhere(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    (tmp_path / "one" / "way.csv").write_text("t,x,y,z\n0,1.0,0.3,1.5\n1,1.0,0.4,1.5\n")
    text = (
        cdpr.load_scenario(CAROCA, overrides=QUIET).resolved_yaml().replace("type: hold", "type: csv\n  file: way.csv")
    )
    text = "\n".join(line for line in text.split("\n") if not line.startswith("  position: [1.0, 0.3, 1.5]"))
    (tmp_path / "one" / "motion.yaml").write_text(text.replace("initial:\n", "initial:\n  position: [1.0, 0.3, 1.5]\n"))
    with cdpr.Simulation(tmp_path / "one" / "motion.yaml") as sim:
        sim.step(3, wrench=[0, 0, 1500, 0, 0, 0])
        sim.step(3)
        sim.save(tmp_path / "two" / "session.yaml")
        assert cdpr.simulate(tmp_path / "two" / "session.yaml").rows.tobytes() == sim.run().rows.tobytes()
    assert "file: ../one/way.csv" in (tmp_path / "two" / "session.yaml").read_text().replace('"', "")


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            lambda lines: [lines[0].replace("fx", "gx"), *lines[1:]],
            r"_outside\.csv:1:1: .*the columns must be t,until,fx",
        ),
        (lambda lines: [lines[0], lines[1].replace("1500.0", "nan")], r"csv:2:1: .*expected a finite number"),
        (lambda lines: [lines[0], lines[1] + ",7"], r"csv:2:1: .*expected 16 cells, got 17"),
        (lambda lines: [*lines, lines[1]], r"csv:3:1: .*t must be at least 0\.003"),
        (lambda lines: [lines[0].replace("cable_1", "cable_x"), lines[1]], "is of a robot with the cables cable_x"),
        (lambda lines: [lines[0], lines[1].rstrip(",") + ",1" * 8], r"csv:2:1: .*expected a wrench, or"),
    ],
)
def test_a_table_that_is_wrong_is_reported(tmp_path, change, text):
    with quiet() as sim:
        sim.step(3, wrench=[0, 0, 1500, 0, 0, 0])
        sim.save(tmp_path / "session.yaml")
    table = tmp_path / "session_outside.csv"
    table.write_text("\n".join(change(table.read_text().splitlines())))
    with pytest.raises(cdpr.ScenarioError, match=text):
        cdpr.load_scenario(tmp_path / "session.yaml")
