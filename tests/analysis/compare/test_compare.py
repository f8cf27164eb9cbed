"""Verdicts of `cdpr compare`, without worker processes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from compare_cases import ENGINES, INSTALLED, Here, comparison, load, off, shrunk

import cdpr
from cdpr.analysis.compare.comparison import compare
from cdpr.analysis.compare.differences import QUANTITIES, apart, difference, pose_apart
from cdpr.analysis.compare.engines import engine_of, field, is_continuous
from cdpr.analysis.compare.excitation import unexcited
from cdpr.analysis.compare.finished import compare_finished
from cdpr.analysis.compare.runs import RunResult, Runs, RunSpec
from cdpr.analysis.compare.scenarios import changes
from cdpr.analysis.compare.verdict import against_scheme, spans
from cdpr.analysis.jobs.pool import Outcome
from cdpr.base.errors import CdprError, LogError, PluginError

SHORT = {"simulation.duration": 0.2}
needs_mujoco = pytest.mark.skipif("mujoco" not in ENGINES, reason="mujoco is not installed")


@pytest.fixture(scope="module")
def run():
    return cdpr.simulate(load("rotated_start", SHORT))


@pytest.mark.parametrize(
    ("name", "field", "by", "size"),
    [
        ("position", "position", [3e-3, 0, 4e-3], 5e-3),
        ("velocity", "velocity", [0, 0, -2e-3], 2e-3),
        ("angular_velocity", "angular_velocity", [0, 1e-2, 0], 1e-2),
        ("tension", "tension", [0, 0, 5.0, 0, -7.0, 0, 0, 0], 7.0),
    ],
)
def test_difference(run, name, field, by, size):
    found = difference(name, run, off(run, field, by))
    assert found.max == pytest.approx(size)
    assert found.rms == pytest.approx(size * np.sqrt(101 / 201))
    assert found.time >= 0.1


def test_difference_of_attitude_is_the_angle_whatever_the_sign(run):
    rows = run.rows.copy()
    turn = cdpr.model.rotations.from_axis_angle(np.array([0.6, 0.0, 0.8]), 1e-3)
    for k in range(len(run.rows)):
        rows[k, run.header.layout.columns["orientation"]] = -cdpr.model.rotations.multiply(turn, run.orientation[k])
    other = dataclasses.replace(run, rows=rows)
    assert difference("attitude", run, other).max == pytest.approx(1e-3)
    assert pose_apart(run, other) == pytest.approx(1e-3 * run.header.characteristic_length)


def test_energy_is_that_which_no_work_explains(run):
    assert difference("energy", run, off(run, "cable_work", 0.25)).max == pytest.approx(0.25)
    assert difference("energy", run, off(off(run, "cable_work", 0.25), "kinetic", 0.25)).max < 1e-9


def test_non_finite_errors_are_infinite_and_short_runs_count(run):
    bad = off(run, "position", np.nan, slice(150, 151))
    assert difference("position", run, bad).max == np.inf
    short = dataclasses.replace(bad, rows=bad.rows[:100])
    assert len(apart("position", run, short)[1]) == 100
    assert difference("position", run, short).max == 0.0


@pytest.mark.parametrize("name", QUANTITIES)
def test_each_bound_is_a_bound(run, name):
    """Just within is agreed, just beyond is not, and the reason names it."""
    columns = {"attitude": "orientation", "energy": "cable_work"}
    bound = QUANTITIES[name].allowed(run)
    for share, outcome in ((0.5, "agrees"), (2.0, "disagrees")):
        by = _tilt(run, share * bound) if name == "attitude" else _one(run, columns.get(name, name), share * bound)
        other = off(run, columns.get(name, name), by)
        verdict = against_scheme(other, run, run, continuous=True)
        assert verdict.outcome == outcome, (share, verdict.checks)
        if outcome == "disagrees":
            assert QUANTITIES[name].title in verdict.reason


def _one(run, name, by):
    """The change `by` in the first column."""
    width = 1 if run[name].ndim == 1 else run[name].shape[1]
    return by if width == 1 else np.eye(width)[0] * by


def _tilt(run, angle):
    """Attitude change by a small rotation about x, from sample 100 on."""
    q = run.orientation[100:]
    return 0.5 * angle * np.column_stack([-q[:, 1], q[:, 0], -q[:, 3], q[:, 2]])


@pytest.fixture(scope="module")
def gram():
    """Caroca at a hundredth of its size, 1 g heavy: tensions of millinewtons."""
    return Here(shrunk("rotated_start", 0.01, 1e-3))


def test_a_sound_engine_agrees_on_a_robot_of_a_gram(gram):
    (group,) = compare(gram, field(gram.scenario, ENGINES), ["qp"], named=True)
    assert group.judge.tension.max() < 0.05
    assert [row.verdict.outcome for row in group.rows] == ["agrees"] * len(ENGINES)


@pytest.mark.parametrize("name", ["position", "velocity", "tension", "cable_work"])
def test_bounds_go_with_the_size_of_the_robot(gram, name):
    """A millionth of what there is lies beyond the bounds, of any robot."""
    gram.make([RunSpec("reference", "qp")])
    run = gram[RunSpec("reference", "qp")].run
    by = 1e-6 * float(np.ptp(run[name], axis=0).max())
    verdict = against_scheme(off(run, name, _one(run, name, by)), run, run, continuous=True)
    assert verdict.outcome == "disagrees", verdict.checks
    assert QUANTITIES["tension"].allowed(run) < 1e-11


def test_cable_tensions_are_compared_in_addition_to_commands():
    run = cdpr.simulate(load("winch", {"simulation.duration": 0.05}))
    other = off(run, "cable_tension", 1e-6 * np.eye(8)[3], slice(20, None))
    assert difference("tension", run, other).max == pytest.approx(1e-6)


UPRIGHT = {"trajectory.to.orientation": {"rpy": [0, 0, 0]}}
BODY = {"type": "payload", "time": 0.05, "mass": 1.0, "center": [0, 0, -0.1]}
SUBSTEPS = "several physics steps in a control step (substeps)"
ALL = {
    "a platform that is not upright (rotation)",
    "a centre of mass off the origin",
    "an external wrench",
    "a tension at its limit",
    SUBSTEPS,
}


@pytest.mark.parametrize(
    ("name", "changes", "happens"),
    [
        ("caroca", UPRIGHT, set()),
        ("rotated_start", {}, {"a platform that is not upright (rotation)", "a centre of mass off the origin"}),
        (
            "caroca",
            {**UPRIGHT, "simulation.physics_step": 5e-4},
            {"several physics steps in a control step (substeps)"},
        ),
        ("caroca", {**UPRIGHT, "robot.tension.max": 130.0}, {"a tension at its limit"}),
        (
            "caroca",
            {**UPRIGHT, "events": [{"type": "wrench", "time": 0.1, "force": [1, 0, 0]}]},
            {"an external wrench"},
        ),
        ("caroca", {**UPRIGHT, "events": [BODY]}, {"a centre of mass off the origin"}),
        ("caroca", {**UPRIGHT, "events": [BODY | {"center": [0, 0, 0]}]}, set()),
        ("caroca", {**UPRIGHT, "events": [BODY | {"time": 100.0}]}, set()),
        ("point_mass", {}, {"a platform that is not upright (rotation)", "a centre of mass off the origin"}),
    ],
)
def test_unexcited_effects_are_listed(name, changes, happens):
    run = cdpr.simulate(load(name, {**SHORT, **changes}))
    assert set(unexcited(run)) == ALL - happens


def test_jumping_tensions_leave_the_pose_to_be_judged(run):
    other = off(run, "tension", 3.0, slice(50, 60))
    verdict = against_scheme(other, run, run, continuous=False)
    assert verdict.outcome == "agrees"
    assert [check.quantity for check in verdict.checks] == ["position", "attitude"]
    assert [(span.samples, round(span.start, 6)) for span in verdict.vertices] == [(10, 0.05)]
    assert against_scheme(other, run, run, continuous=True).outcome == "disagrees"
    assert against_scheme(off(run, "position", 1e-6), run, run, continuous=False).outcome == "disagrees"


def test_other_statuses_are_listed(run):
    other = off(run, "status", 1, slice(20, 23))
    verdict = against_scheme(other, run, run, continuous=True)
    assert [(span.samples, round(span.end, 6)) for span in verdict.statuses] == [(3, 0.022)]
    assert spans(run, np.zeros(len(run.rows), dtype=bool)) == ()


@pytest.mark.parametrize(("status", "rows"), [("diverged", 150), ("infeasible", 201), ("finished", 150)])
def test_another_end_disagrees(run, status, rows):
    other = dataclasses.replace(run, status=status, rows=run.rows[:rows])
    verdict = against_scheme(other, run, run, continuous=True)
    assert verdict.outcome == "disagrees"
    assert "the run ended" in verdict.reason


def test_judge_is_of_highest_order():
    chosen = field(load("caroca"), None)
    assert chosen.judge.name == "reference"
    standards = {engine.name: engine.standard(chosen.judge) for engine in chosen.engines}
    assert set(standards) == INSTALLED - {"reference"}
    assert set(standards.values()) == {"scheme"}


@needs_mujoco
@pytest.mark.parametrize(
    ("options", "order", "standard"),
    [
        ({}, 1, "scheme"),
        ({"cables": "native"}, 1, "scheme"),
        ({"cables": "native", "integrator": "rk4"}, 4, "order"),
        ({"cables": "ups"}, 0, "none"),
    ],
)
def test_options_change_how_an_engine_is_judged(options, order, standard):
    scenario = load("caroca", {"backend_options.mujoco": options} if options else {})
    chosen = field(scenario, ["mujoco"])
    (engine,) = chosen.engines
    assert (engine.order, engine.standard(chosen.judge)) == (order, standard)


@needs_mujoco
def test_every_standard_in_a_loop():
    for options, outcome in (
        ({"cables": "native"}, "agrees"),
        ({"cables": "native", "integrator": "rk4"}, "agrees"),
        ({"cables": "ups"}, "not judged"),
    ):
        figures = comparison("caroca", ["mujoco"], {"backend_options.mujoco": options, **SHORT}).figures
        (row,) = figures["groups"][0]["engines"]
        assert row["outcome"] == outcome, row
        assert figures["agrees"] is (True if outcome == "agrees" else None)


def test_engines_that_are_not_installed_are_reported(monkeypatch):
    """By name they are an error with its remedy; among all they are listed."""
    missing = property(lambda self: ["dartpy"] if self.info.name == "dart" else [])
    monkeypatch.setattr("cdpr.plugins.registry.Registered.missing", missing)
    chosen = field(load("caroca"), None)
    assert chosen.absent == {"dart": "not installed: pip install 'cdpr[dart]'"}
    assert "dart" not in {engine.name for engine in chosen.engines}
    with pytest.raises(PluginError, match="dartpy, which is not installed"):
        field(load("caroca"), ["dart", "mujoco"])


def test_nothing_to_compare_is_an_error():
    with pytest.raises(CdprError, match="nothing to compare: 'reference' is the judge"):
        field(load("caroca"), ["reference"])
    with pytest.raises(PluginError, match="did you mean 'mujoco'"):
        field(load("caroca"), ["mujuco"])


def test_continuity_is_what_solver_or_controller_declare():
    assert is_continuous(load("caroca"))
    assert not is_continuous(load("caroca").with_changes(solver="lp"))
    assert is_continuous(load("caroca").with_changes(solver="lp", controller="cable_length"))


def test_wanted_runs_keep_the_control_period():
    scenario = load("caroca", {"simulation.control_step": 0.002, "simulation.duration": 1.0})
    plain = scenario.with_changes(RunSpec("reference", "qp").changes(scenario))
    assert plain.simulation.physics_step == scenario.simulation.physics_step
    halved = scenario.with_changes(RunSpec("reference", "qp", divide=8).changes(scenario)).simulation
    assert (halved.control_step, halved.substeps) == (0.002, 8)
    longer = scenario.with_changes(RunSpec("reference", "qp", divide=2, stretch=30).changes(scenario)).simulation
    assert (longer.control_step, longer.substeps, longer.steps) == (pytest.approx(0.06), 2, 16)
    scheme = scenario.with_changes(RunSpec("reference", "qp", "semi_implicit_euler").changes(scenario))
    assert engine_of(scheme, "reference").order == 1


def test_every_sample_is_compared_whatever_the_log_keeps():
    scenario = load("caroca", {"log.step": 0.1})
    for wanted in (RunSpec("reference", "qp"), RunSpec("reference", "qp", divide=2, stretch=30)):
        assert scenario.log_every > 1 == scenario.with_changes(wanted.changes(scenario)).log_every


def test_runs_are_read_on_demand(monkeypatch, tmp_path):
    """However many there are, none waits in memory."""

    def ended(cases, *, jobs, timeout, done):
        for case in cases:
            cdpr.simulate(load("caroca", SHORT), overrides=case.changes, out=case.out)
            done(Outcome(case.key, "finished", "", case.out))

    monkeypatch.setattr("cdpr.analysis.compare.runs.run_cases", ended)
    read, real = [], cdpr.analysis.compare.runs.read
    monkeypatch.setattr("cdpr.analysis.compare.runs.read", lambda outcome: read.append(outcome.key) or real(outcome))
    runs, wanted = Runs(load("caroca", SHORT), tmp_path, 1, None, lambda done, total: None), RunSpec("reference", "qp")
    runs.make([wanted])
    assert read == []
    assert runs[wanted].complete
    assert read == ["reference_qp"]


class Failing(Here):
    """One backend stops by a signal."""

    ends = RunResult(None, "died", "the process of this case was ended by SIGSEGV\nmore", begun=True)

    def _one(self, wanted):
        return self.ends if wanted.backend == ENGINES[0] else super()._one(wanted)


@pytest.mark.parametrize(
    ("ends", "named", "outcome", "agrees"),
    [
        (RunResult(None, "died", "killed"), False, "failed", False),
        (RunResult(None, "hung", "no answer after 3 s"), False, "failed", False),
        (RunResult(None, "failed", "a plugin raised", begun=True), False, "failed", False),
        (RunResult(None, "failed", "only free platforms", begun=False), False, "not run", None),
        (RunResult(None, "failed", "only free platforms", begun=False), True, "failed", False),
    ],
)
def test_engines_that_fail(monkeypatch, ends, named, outcome, agrees):
    monkeypatch.setattr(Failing, "ends", ends)
    scenario = load("caroca", SHORT)
    chosen = field(scenario, [ENGINES[0]])
    (group,) = compare(Failing(scenario), chosen, ["qp"], named=named)
    assert group.rows[0].verdict.outcome == outcome
    assert ends.message in group.rows[0].verdict.reason
    assert group.agrees is agrees


def test_a_diverged_reference_judges_no_engine():
    wild = {"controller.kp": 5e6, "controller.kd": 4000.0, "robot.tension.max": 1e7}
    group = comparison("caroca", [ENGINES[0]], wild).groups[0]
    assert group.agrees is False
    assert "the judge, reference, diverged" in group.problem


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Finished runs."""
    root = tmp_path_factory.mktemp("finished")
    for name, scenario, choice, more in (
        ("judge", "caroca", {}, {}),
        ("one", "caroca", {"backend": ENGINES[0]}, {}),
        ("other", "caroca", {"backend": ENGINES[-1]}, {}),
        ("gains", "caroca", {"backend": ENGINES[-1]}, {"controller.kp": 90.0}),
        ("slow", "caroca", {}, {"simulation.control_step": 0.002}),
        ("robot", "planar", {}, {}),
    ):
        cdpr.simulate(load(scenario, {**SHORT, **more}), out=root / name, **choice)
    return root


def test_finished_runs(folders):
    figures = compare_finished([str(folders / name) for name in ("one", "judge", "other")]).figures
    assert figures["judge"] == {"backend": "judge", "order": 4}
    (group,) = figures["groups"]
    assert [row["label"] for row in group["engines"]] == ["one", "other"]
    assert {row["outcome"] for row in group["engines"]} == {"agrees"}
    assert figures["agrees"] is True


def test_finished_runs_are_labelled_by_all_solvers(folders, tmp_path):
    cdpr.simulate(load("caroca", SHORT), solver="lp", out=tmp_path / "lp")
    (group,) = compare_finished([str(folders / "judge"), str(tmp_path / "lp")]).figures["groups"]
    assert group["solver"] == "qp, lp"
    assert "solver.type" in group["engines"][0]["reason"]


def test_finished_runs_of_other_gains_are_reported_not_judged(folders):
    figures = compare_finished([str(folders / name) for name in ("one", "gains")]).figures
    (row,) = figures["groups"][0]["engines"]
    assert figures["agrees"] is None
    assert "controller.kp" in row["reason"]
    assert row["differences"]["tension"]["max"] > 0.0


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["judge"], "two or more runs, got one"),
        (["judge", "judge"], "given twice"),
        (["judge", "slow"], r"slow: cannot be compared with judge: other control step \(0.002 instead of 0.001\)"),
        (["judge", "robot"], "robot: cannot be compared with judge: other robot"),
    ],
)
def test_finished_runs_that_cannot_be_compared(folders, names, message):
    with pytest.raises(CdprError, match=message):
        compare_finished([str(folders / name) for name in names])


@pytest.mark.parametrize("paths", [[], (), "judge"])
def test_finished_runs_that_are_no_list(paths):
    with pytest.raises(CdprError, match="expected a list of two or more run folders or logs, got"):
        compare_finished(paths)


def test_finished_runs_that_are_not_there(folders):
    with pytest.raises(LogError, match="no such file"):
        compare_finished([str(folders / "judge"), str(folders / "nobody")])


def test_changes_of_a_scenario():
    one, other = load("caroca"), load("caroca", {"controller.kp": 50, "robot.cables[2].frame[0]": 3.4})
    assert changes(one.resolved_yaml(), one.resolved_yaml()) == []
    found = {key: (old, new) for key, old, new in changes(one.resolved_yaml(), other.resolved_yaml())}
    assert found["controller.kp"] == ("100.0", "50.0")
    assert "robot.cables[2].frame" in found
    assert len(found) == 2
