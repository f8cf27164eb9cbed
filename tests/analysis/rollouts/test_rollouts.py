"""Rollouts: each case equals `simulate` to the bit, early stops are reported, and a folder can be resumed."""

from __future__ import annotations

import copy
import errno
import json
import os
import pickle

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.analysis.jobs.draw import Random, drawn
from cdpr.analysis.rollouts.case import BLOCK
from cdpr.base.columns import FIRST
from cdpr.base.errors import CdprError, OutputError, ScenarioError

SCENARIOS = ROOT / "scenarios"
CAROCA = SCENARIOS / "caroca.yaml"
SHORT = {"simulation.duration": 0.2}
ALL = tuple(column.name for column in FIRST if column.name != "time")
MASS = {"robot.platform.mass": [24.0, 25.0, 26.0]}


def rollout(n=3, vary=MASS, *, scenario=CAROCA, overrides=SHORT, **more):
    return cdpr.rollout(scenario, n, vary=vary, overrides=overrides, **more)


def alone(found, i, scenario, overrides):
    """The run of case i by itself; what ends it is in its status."""
    own = {key: values[i] for key, values in found.values.items()}
    try:
        return cdpr.simulate(scenario, overrides={**overrides, **own})
    except cdpr.SimulationStopped as stop:
        return stop.run


@pytest.fixture(scope="module")
def found():
    return rollout()


KINDS = {
    "caroca": {
        "robot.platform.mass": [24.0, 30.0],
        "controller.kp": [100.0, 300.0],
        "initial.position": [[0.0, 0.1, 1.2], [0.05, 0.0, 1.25]],
        "robot.cables[2].frame[0]": {"normal": [3.5, 0.01]},
    },
    "cable_break": {"events[0].time": [0.05, 0.1]},
    "external_wrench": {"robot.platform.mass": {"uniform": [24.0, 26.0]}},
    "believed": {"controller.kd": [20.0, 30.0], "believed.platform.mass": [138.0, 141.0]},
    "winch": {"controller.kp": {"log_uniform": [50.0, 100.0]}},
    "cogiro_pulleys": {"robot.platform.mass": {"uniform": [90.0, 110.0]}},
    "planar": {"world.gravity": [[0.0, 0.0, -9.81], [0.0, 0.0, -1.62]]},
    "spherical": {"controller.kp": [50.0, 60.0]},
}


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.usual("caroca", "winch", "planar")
def test_a_case_is_what_simulate_gives_to_the_bit(name):
    path = SCENARIOS / f"{name}.yaml"
    overrides = {**SHORT, "simulation.backend": "reference"}
    found = rollout(2, KINDS[name], scenario=path, overrides=overrides, every=1, columns=ALL)
    for i in range(2):
        run = alone(found, i, path, overrides)
        assert (found.status[i], found.outcomes[i].message) == (run.status, run.message)
        kept = [run.header.layout.columns[column] for column in ALL]
        expected = np.concatenate([run.rows[:, at] for at in kept], axis=1)
        assert np.array_equal(found.rows[i, : len(expected)], expected, equal_nan=True)
        assert np.isnan(found.rows[i, len(expected) :]).all()


def test_many_blocks_and_thinning():
    """Longer than the ring of samples, and kept are every so manyth and the last."""
    overrides = {"simulation.duration": 2.5}
    every = 7
    found = rollout(2, {"controller.kd": [20.0, 30.0]}, overrides=overrides, every=every, threads=2)
    run = alone(found, 1, CAROCA, overrides)
    assert len(run.rows) > 2 * BLOCK
    at = [*range(0, 2501, every), 2500]
    assert np.array_equal(found.time, run.time[at])
    assert np.array_equal(found.position[1], run.position[at])
    assert np.array_equal(found.tension[1], run.tension[at])
    seconds = rollout(2, {"controller.kd": [20.0, 30.0]}, overrides=overrides, every=0.007)
    assert np.array_equal(seconds.rows, found.rows)


@pytest.mark.parametrize("name", ["caroca", "cable_break", "thesis"])
def test_figures_are_those_of_the_summary(name):
    path = SCENARIOS / f"{name}.yaml"
    overrides = {**SHORT, "simulation.backend": "reference"}
    found = rollout(1, {"world.gravity": [[0.0, 0.0, -9.0]]}, scenario=path, overrides=overrides)
    summary = alone(found, 0, path, overrides).summary()
    figures = {name: values[0] for name, values in found.figures.items()}
    for name in ("samples", "infeasible_steps", "unanswered_steps"):
        assert figures[name] == summary[name]
    for kind, unit in (("position", "m"), ("orientation", "rad")):
        told = summary[f"{kind}_error_{unit}"]
        for part in ("max", "rms", "final"):
            assert figures[f"{kind}_error_{part}_{unit}"] == pytest.approx(told[part], rel=1e-9, abs=1e-12)
    assert [figures["tension_min_N"], figures["tension_max_N"]] == [summary["tension_N"][x] for x in ("min", "max")]


def test_external_commands_take_effect(tmp_path):
    with cdpr.Simulation(CAROCA, overrides=SHORT) as sim:
        sim.step(20)
        sim.step(10, wrench=[5.0, 0.0, 300.0, 0.0, 0.0, 0.0])
        while not sim.done:
            sim.step()
        sim.save(tmp_path / "session.yaml")
    found = rollout(2, {"controller.kp": [90.0, 110.0]}, scenario=tmp_path / "session.yaml", overrides={}, every=1)
    run = alone(found, 1, tmp_path / "session.yaml", {})
    assert np.array_equal(found.position[1], run.position)


def test_results(found):
    assert repr(found).startswith("<Rollouts of caroca: 3 cases (3 finished), 101 samples each of position, ")
    assert found.position.shape == (3, 101, 3)
    assert found.tension.shape == (3, 101, 8)
    assert found.messages == ["", "", ""]
    summary = found.summary()
    assert summary["finished_share"] == 1.0
    assert summary["tension_max_N"]["max"] == found.figures["tension_max_N"].max()
    with pytest.raises(
        AttributeError, match="velocity: not recorded; recorded columns: position, orientation, tension"
    ):
        found.velocity  # noqa: B018
    with pytest.raises(ValueError, match="read-only"):
        found.position[0] = 0.0


def test_it_can_be_copied(found):
    twin = pickle.loads(pickle.dumps(found))
    assert np.array_equal(twin.position, found.position)
    assert np.array_equal(copy.copy(found)["tension"], found.tension)
    with pytest.raises(KeyError, match="velocity: not recorded"):
        found["velocity"]


class Asleep(cdpr.plugins.Controller):
    """Requests no wrench, in Python."""

    def control(self, time, state, desired, out):
        out[:] = 0.0


def test_python_parts_run_in_one_thread():
    registry, name = cdpr.load_scenario(CAROCA).plugins.with_class("controller", Asleep)
    scenario = cdpr.load_scenario(CAROCA, controller=name, plugins=registry, overrides=SHORT)
    found = rollout(scenario=scenario, overrides={})
    run = cdpr.simulate(scenario, overrides={"robot.platform.mass": 25.0})
    assert np.array_equal(found.position[1], run.position[::2])
    with pytest.raises(CdprError, match="threads: 2 threads have no effect: backend, controller or solver"):
        rollout(scenario=scenario, overrides={}, threads=2)


def test_threads_change_nothing(found):
    assert np.array_equal(rollout(threads=1).rows, found.rows)


def test_draws_are_those_of_a_study_and_more_begin_with_fewer():
    key, given = "robot.platform.mass", {"uniform": [24.0, 26.0]}
    few, many = rollout(2, {key: given}, seed=5), rollout(4, {key: given}, seed=5)
    assert few.values[key].tolist() == many.values[key][:2].tolist()
    assert np.array_equal(few.rows, many.rows[:2])
    assert many.values[key].tolist() == drawn(Random(**{"uniform": (24.0, 26.0), "count": 4}), f"5 {key}")


def test_early_stops_are_reported_for_each_case():
    vary = {
        "controller.kp": [100.0, 1e6, 100.0, 100.0],
        "robot.platform.mass": [25.0, 25.0, 10000.0, -1.0],
        "robot.tension.max": [2000.0, 1e11, 2000.0, 2000.0],
        "simulation.physics_step": [0.01] * 4,
        "solver.infeasible": ["best_effort", "best_effort", "stop", "stop"],
    }
    overrides = {"simulation.duration": 2.0, "simulation.control_step": 0.01}
    found = rollout(4, vary, overrides=overrides)
    assert found.status.tolist() == ["finished", "diverged", "infeasible", "failed"]
    assert "robot.platform.mass" in found.messages[3]
    assert np.isfinite(found.position[1, 0]).all()
    assert np.isnan(found.position[1, -1]).all()
    assert found.counts == {"finished": 1, "diverged": 1, "infeasible": 1, "failed": 1}
    assert found.summary()["finished_share"] == 0.25


WRONG = {
    "n": ({"n": 0}, "expected a whole number of cases from 1 to 100000, got 0"),
    "negative": ({"n": -1}, "got -1"),
    "no number": ({"n": True}, "got true"),
    "nothing varied": ({"vary": {}}, "vary: expected {key: values} of at least one key"),
    "unknown key": ({"vary": {"robot.platfrom.mass": [1.0] * 3}}, "case 0: robot.platfrom: "),
    "no key": ({"vary": {"robot..mass": [1.0] * 3}}, "expected a key such as simulation.duration"),
    "too few": ({"vary": {"robot.platform.mass": [1.0, 2.0]}}, "expected a value for each of the 3 cases, got 2"),
    "shape": ({"vary": {"initial.position": np.zeros((2, 3))}}, r"expected .*, got 2 \(shape \(2, 3\)\)"),
    "value's shape": ({"vary": {"initial.position": np.zeros((3, 2))}}, "case 0: initial.position: "),
    "scalar": ({"vary": {"robot.platform.mass": 25.0}}, "expected an array of 3 values or a distribution"),
    "NaN": (
        {"vary": {"robot.platform.mass": [25.0, np.nan, 25.0]}},
        "expected finite numbers, got nan for case 1",
    ),
    "distribution": ({"vary": {"robot.platform.mass": {"uniform": [2.0, 1.0]}}}, "the lowest value, 2, must be below"),
    "unknown distribution": ({"vary": {"robot.platform.mass": {"gauss": [2.0, 1.0]}}}, "gauss"),
    "twice": ({"vary": {"initial": [{}] * 3, "initial.position": [[0, 0, 1]] * 3}}, "overlaps with it"),
    "overridden": ({"vary": {"simulation.duration": [1.0] * 3}}, "have the same samples"),
    "also overridden": ({"overrides": {"robot.platform.mass": 3.0}}, "overrides set robot.platform.mass"),
    "seed": ({"seed": -1}, "seed: expected a whole number from 0 to"),
    "every": ({"every": 0}, "every: expected a whole number of samples"),
    "seconds": ({"every": 0.00015}, "every: "),
    "column": ({"columns": ["postion"]}, "unknown column 'postion': did you mean"),
    "threads": ({"threads": 0}, "threads: expected a whole number from 1 on"),
    "progress": ({"progress": None}, "progress: expected a function, got null"),
    "array of overrides": ({"overrides": np.array(3)}, "overrides: expected .*, got 3"),
    "both": ({"threads": 1, "scheduler": "tcp://127.0.0.1:1"}, "threads does not go with scheduler"),
    "backend": ({"backend": "none_such"}, "none_such"),
}


@pytest.mark.parametrize("name", WRONG)
def test_one_clear_error(name):
    given, text = WRONG[name]
    with pytest.raises(CdprError, match=text) as told:
        rollout(**given)
    assert len(str(told.value).splitlines()) == 1


def test_more_threads_than_a_system_has_are_as_many_as_cases():
    assert len(rollout(threads=10**30).rows) == 3


def test_all_errors_of_values_are_reported_together():
    with pytest.raises(ScenarioError) as told:
        rollout(vary={"robot.platform.mass": [np.inf] * 3, "controller.kp": [1.0]})
    assert len(told.value.problems) == 2


def test_an_interrupt_keeps_finished_cases_and_the_same_call_continues(tmp_path):
    vary = {"controller.kd": {"uniform": [20.0, 30.0]}}
    whole = rollout(40, vary)

    def interrupt(done, total):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rollout(40, vary, out=tmp_path / "out", progress=interrupt)
    lines = (tmp_path / "out" / "cases.jsonl").read_text().splitlines()
    assert 0 < len(lines) < 40
    begun = []
    again = rollout(40, vary, out=tmp_path / "out", progress=lambda done, total: begun.append(done))
    assert begun[0] == len(lines)
    assert np.array_equal(again.rows, whole.rows)
    assert again.figures.keys() == whole.figures.keys()
    assert all(np.array_equal(again.figures[name], whole.figures[name]) for name in whole.figures)


def test_a_folder_holds_one_rollout(tmp_path):
    out = tmp_path / "out"
    first = rollout(out=out)
    assert json.loads((out / "rollout.json").read_text())["cases"] == 3
    with pytest.raises(OutputError, match="contains another rollout, 'caroca' of 3 cases"):
        rollout(2, {"robot.platform.mass": [24.0, 25.0]}, out=out)
    (out / "rows.npy").unlink()  # the result has it mapped
    (out / "rows.npy").write_bytes(b"damaged")
    with pytest.warns(UserWarning, match=r"rows\.npy: 3 damaged of 3 cases; repeating them: 0, 1, 2"):
        again = rollout(out=out)
    assert np.array_equal(again.rows, first.rows)
    (out / "rows.npy").unlink()
    (out / "rows.npy").mkdir()
    with pytest.raises(OutputError, match=r"rows\.npy"):
        rollout(out=out)


def test_failed_cases_are_repeated(tmp_path):
    vary = {"robot.platform.mass": [25.0, -1.0]}
    assert rollout(2, vary, out=tmp_path / "out").status.tolist() == ["finished", "failed"]
    begun = []
    rollout(2, vary, out=tmp_path / "out", progress=lambda done, total: begun.append(done))
    assert begun == [1, 2]


def test_rows_beyond_memory_need_a_folder():
    with pytest.raises(CdprError, match="GiB of memory: give a folder, out=, set a larger every="):
        rollout(100_000, {"controller.kp": np.linspace(100, 200, 100_000)}, overrides={}, every=1, columns=ALL)


def test_export(found, tmp_path):
    found.save(tmp_path / "found.npz")
    with np.load(tmp_path / "found.npz", allow_pickle=False) as data:
        assert np.array_equal(data["position"], found.position)
        assert data["vary:robot.platform.mass"].tolist() == MASS["robot.platform.mass"]
        assert data["status"].tolist() == ["finished"] * 3
    with pytest.raises(OutputError, match="exists"):
        found.save(tmp_path / "found.npz")
    with pytest.raises(OutputError, match=r"ends in \.npz or \.parquet"):
        found.save(tmp_path / "found.csv")


def test_tables(found, tmp_path):
    pandas, _ = pytest.importorskip("pandas"), pytest.importorskip("pyarrow")
    found.save(tmp_path / "found.parquet")
    table = pandas.read_parquet(tmp_path / "found.parquet")
    assert len(table) == 3 * 101
    assert np.array_equal(table["position_x_m"].to_numpy().reshape(3, 101), found.position[:, :, 0])
    assert table["case"].tolist()[::101] == [0, 1, 2]
    frame = found.to_pandas()
    assert frame["robot.platform.mass"].tolist() == MASS["robot.platform.mass"]
    assert frame["tension_max_N"].tolist() == found.figures["tension_max_N"].tolist()


def test_a_scenario_whose_other_keys_change_is_checked_as_a_file_is():
    """Values taken from the previous scenario equal those of a file with these values."""
    base = cdpr.load_scenario(CAROCA)
    base.planned  # noqa: B018
    for changes in (
        {"controller.kp": 70.0},
        {"robot.platform.mass": 30.0},
        {"initial.position": [0.1, 0.0, 1.2]},
        {"world.gravity": [0.0, 0.0, -1.6]},
        {"robot.platform.center_of_mass": [0.0, 0.01, 0.02], "robot.cables[2].frame[0]": 3.0},
        {"robot.platform.mass": 30.0, "robot.frame.position": [0.0, 0.0, 0.1]},
        {"robot.platform.shape": {"box": [0.3, 0.2, 0.1]}},
        {"robot.platform.mass": 30.0, "robot.tension.max": 900.0, "robot.home": {"position": [0.0, 0.0, 1.1]}},
    ):
        changed = base.with_changes(changes)
        loaded = cdpr.load_scenario(CAROCA, overrides=changes)
        assert changed == loaded
        assert changed.planned.sample(0.3).tolist() == loaded.planned.sample(0.3).tolist()
        for what in ("inertial", "anchors", "tension_min", "tension_max", "home"):
            assert np.array_equal(getattr(changed.robot, what), getattr(loaded.robot, what)), what
        assert changed.robot.platform.outline == loaded.robot.platform.outline
        edges = [robot.frame.edges.tolist() if robot.frame else None for robot in (changed.robot, loaded.robot)]
        assert edges[0] == edges[1]
    for changes in (
        {"robot.platform.mass": None},
        {"events": [{"type": "wrench", "time": 0.1, "force": None}]},
        {"events": [{"type": "cable_break", "time": 0.1, "cable": "none such"}]},
        {"robot.cables[3].platform": [0.0, 0.0, "x"], "robot.cables[4].frame": None},
    ):
        with pytest.raises(ScenarioError) as of_change:
            base.with_changes(changes)
        with pytest.raises(ScenarioError) as of_file:
            cdpr.load_scenario(CAROCA, overrides=changes)
        assert str(of_change.value) == str(of_file.value)
    with pytest.raises(ScenarioError, match=r"initial\.position"):
        base.with_changes(
            {"initial.position": base.robot.anchors[0, :3].tolist(), "robot.cables[0].platform": [0, 0, 0]}
        )


def test_rows_that_cannot_be_read_are_an_error_of_the_folder(tmp_path, monkeypatch):
    out = tmp_path / "out"
    rollout(out=out)

    def fails(*_):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "pread", fails)
    with pytest.raises(OutputError, match=r"rows\.npy: cannot be read: Input/output error"):
        rollout(out=out)


HANGING = {"model": "elastic", "axial_stiffness": 1e4, "damping": 50.0}
ONE_CABLE = {
    "ideal": {},
    "winch": {"cable": HANGING, "winch": {"drum_radius": 0.05, "inertia": 1e-3}},
    "position": {"cable": HANGING, "winch": {"type": "position"}},
}


@pytest.mark.parametrize("kind", ONE_CABLE)
def test_one_cable_and_one_degree_of_freedom_keep_their_axes(kind):
    """Columns of cables are (cases, samples, m), also for m = 1, in fresh cases and in those that reuse a loop."""
    robot = {
        "name": "one",
        "platform": {"mass": 2.0},
        "dof": ["z"],
        "tension": {"min": 1.0, "max": 500.0},
        "home": {"position": [0.0, 0.0, 1.0]},
        "cables": [{"frame": [0.0, 0.0, 3.0], "platform": [0.0, 0.0, 0.0]}],
        **ONE_CABLE[kind],
    }
    controller = {"type": "inverse_kinematics"} if kind == "position" else {"type": "computed_torque"}
    data = {"robot": robot, "trajectory": {"type": "hold"}, "controller": controller}
    data["simulation"] = {"backend": "reference", "duration": 0.02, "control_step": 0.001}
    names = ("position", "tension", "residual")
    masses = {"robot.platform.mass": np.linspace(1.5, 3.5, 18)}  # more than a chunk and its lanes
    found = cdpr.rollout(data, 18, vary=masses, every=1, columns=names)
    assert found.status.tolist() == ["finished"] * 18
    assert (found.tension.shape, found["residual"].shape) == ((18, 21, 1), (18, 21))
    for i in range(18):
        run = alone(found, i, data, {})
        for name in names:
            assert np.array_equal(found[name][i], run[name], equal_nan=True), (i, name)
