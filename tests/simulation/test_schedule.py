"""Effects of events on plant, distribution and record, shown by the resulting motion."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from plants import installed

import cdpr
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr.trajectory import Stopping

CAROCA = ROOT / "scenarios" / "caroca.yaml"
H = 1e-3
MASS, INERTIA_Z = 150.0, 22.5
WEIGHT = MASS * 9.81

# Here caroca can do without its second cable; in the middle of its frame it can spare none.
PLACE = [1.0, 0.3, 1.5]
HOLD = {"trajectory": {"type": "hold"}, "simulation.duration": 0.1}


def run(*events, scenario=CAROCA, **changes):
    choice = {key: changes.pop(key) for key in ("backend", "controller", "solver") if key in changes}
    place = {"initial.position": PLACE} if scenario == CAROCA else {}
    overrides = {**HOLD, **place, "events": list(events), **changes}
    return cdpr.simulate(scenario, overrides=overrides, **choice)


def told(run):
    return [(round(event.time, 9), event.kind) for event in run.events]


def break_of(cable, time=0.05, **more):
    return {"type": "cable_break", "time": time, "cable": cable, **more}


def test_without_events_nothing_changes():
    """To the bit, and the loop calls the stage itself."""
    assert run().rows.tobytes() == cdpr.simulate(CAROCA, overrides={**HOLD, "initial.position": PLACE}).rows.tobytes()
    loop = Loop(build(cdpr.load_scenario(CAROCA)))
    assert loop.schedule.through(loop.stage) == loop.stage.operations
    assert loop.schedule.begin() == -1


def test_nothing_changes_before_an_event():
    for event in (break_of(1), {"type": "emergency_stop", "time": 0.05}, {"type": "limits", "time": 0.05, "min": 60}):
        assert run(event).rows[:50].tobytes() == run().rows[:50].tobytes()


def test_the_same_twice_in_one_loop_and_in_two():
    scenario = cdpr.load_scenario(
        CAROCA,
        overrides={
            **HOLD,
            "initial.position": PLACE,
            "events": [
                break_of(2),
                {"type": "wrench", "time": 0.02, "force": [9, 0, 0]},
                {"type": "limits", "time": 0.03, "max": 900},
            ],
        },
    )
    loop, start = Loop(build(scenario)), scenario.initial.state()
    rows = np.empty((2, 101, len(loop.row)))
    for k in range(2):
        loop.warm_up(start)
        loop.run(rows[k], lambda _: None)
    assert rows[0].tobytes() == rows[1].tobytes() == cdpr.simulate(scenario).rows.tobytes()


@pytest.mark.parametrize("backend", installed("reference", "mujoco", "bullet", "dart"))
def test_a_wrench_accelerates_the_platform(backend):
    """It holds still; one step of a force changes its velocity by F / m times the step, of a moment by M / I."""
    still = run(backend=backend)
    pushed = run({"type": "wrench", "time": 0.0195, "force": [300, 0, -60], "moment": [0, 0, 45]}, backend=backend)
    np.testing.assert_array_equal(np.flatnonzero(pushed.external.any(axis=1)), np.arange(20, 101))
    np.testing.assert_array_equal(pushed.external[20], [300, 0, -60, 0, 0, 45])
    change = (pushed.rows - still.rows)[21]
    columns = pushed.header.layout.columns
    # The pose moves within the step by h^2 F / 2 m = 1e-6 m, and the cables pull a millionth otherwise.
    np.testing.assert_allclose(change[columns["velocity"]], H * np.array([300, 0, -60]) / MASS, rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose(change[columns["angular_velocity"]], [0, 0, H * 45 / INERTIA_Z], rtol=1e-6, atol=1e-8)
    assert told(pushed) == [(0.02, "wrench")]


def test_a_push_ends_and_loads_add_up():
    both = run(
        {"type": "wrench", "time": 0.01, "duration": 0.02, "force": [10, 0, 0]},
        {"type": "wrench", "time": 0.02, "force": [1, 2, 0]},
    )
    expected = np.zeros(101)
    expected[10:30] += 10.0
    expected[20:] += 1.0
    np.testing.assert_array_equal(both.external[:, 0], expected)
    assert [event.until for event in both.events] == [0.03, None]


def test_a_sine_is_sampled():
    swing = {"type": "sine", "time": 0.02, "duration": 0.05, "frequency": 50.0, "phase": 0.25, "moment": [0, 8.0, 0]}
    t = H * np.arange(101)
    expected = np.where((t > 0.0195) & (t < 0.0695), 8.0 * np.sin(100.0 * np.pi * (t - 0.02) + 0.25), 0.0)
    np.testing.assert_allclose(run(swing).external[:, 4], expected, rtol=0, atol=1e-12)


def test_a_broken_cable_pulls_no_more_and_the_others_carry_the_wrench():
    broken = run(break_of("cable_2"))
    assert np.all(broken.tension[50:, 1] == 0.0)
    assert broken.tension[49, 1] > 100.0
    assert np.all(broken.solver_status == 0)
    assert broken.residual.max() < 1e-9
    assert np.abs(broken.position_error).max() < 1e-9  # no drop at all
    assert broken.margin[50:].min() > 50.0  # the locked cable is none that could leave its limits
    assert np.all(broken.at_limit == 0)


def test_a_late_detection_leaves_the_load_to_the_plant():
    late = run(break_of("cable_2", detected_after=0.02))
    assert np.all(late.tension[50:, 1] == 0.0)
    blind, aware = slice(50, 70), slice(70, None)
    assert late.residual[blind].min() > 100.0  # that wrench is missing, also in the record
    assert late.margin[blind].min() > 50.0  # of the others: the broken cable does not hide them
    assert late.residual[aware].max() < 1e-9
    # The wrench that is missing in the first period accelerates the platform.
    missing = late.tension[49, 1] * direction(late, 1)
    np.testing.assert_allclose(late.velocity[51] - late.velocity[50], -missing * H / MASS, rtol=1e-4, atol=1e-9)
    assert told(late) == [(0.05, "cable_break"), (0.07, "detected")]
    assert told(run(break_of("cable_2", detected_after=20.0))) == [(0.05, "cable_break")]  # the run is over by then


def direction(run, i, k=50):
    """Unit vector of cable i at sample k, upright platform."""
    anchors = np.array(run.header.anchors)
    along = anchors[i, :3] - run.position[k] - anchors[i, 3:]
    return along / np.linalg.norm(along)


def test_a_jammed_cable_keeps_its_tension_until_it_breaks():
    jammed = run(
        {"type": "cable_jam", "time": 0.03, "cable": 4},
        {"type": "wrench", "time": 0.04, "force": [0, 500, 0]},
        {"type": "cable_break", "time": 0.08, "cable": 4},
        **{"controller.kp": 1000, "controller.kd": 60},
    )
    frozen = jammed.tension[29, 3]
    assert np.all(jammed.tension[30:80, 3] == frozen)
    assert np.ptp(jammed.tension[40:80, 2]) > 10.0  # while the others answer the push
    assert jammed.residual[:80].max() < 1e-9
    assert np.all(jammed.tension[80:, 3] == 0.0)
    assert f"jams at {frozen:.5g} N" in jammed.events[0].text


def test_limits_change():
    limited = run(
        {"type": "limits", "time": 0.03, "max": 500},
        {"type": "limits", "time": 0.06, "cable": 2, "min": 353.0},
    )
    assert limited.tension[:30].max() > 510.0
    assert limited.tension[30:].max() <= 500.0
    assert limited.tension[30:60, 1].max() < 351.0 < 353.0 <= limited.tension[60:, 1].min()
    assert limited.tension[60:].max() <= 500.0  # what the second event does not name stays
    assert np.all(limited.solver_status == 0)
    assert [event.text for event in limited.events] == [
        "the tension limits of all cables become max 500 N",
        "the tension limits of cable 'cable_2' become min 353 N",
    ]


def test_limits_of_all_spare_a_broken_cable():
    assert np.all(run(break_of(2), {"type": "limits", "time": 0.07, "min": 60}).solver_status == 0)


def test_a_stop_without_power_lets_the_platform_fall():
    fall = run({"type": "emergency_stop", "time": 0.05, "category": 0}, **{"solver.infeasible": "stop"})
    assert np.all(fall.tension[50:] == 0.0)
    t = H * np.arange(51)
    np.testing.assert_allclose(fall.position[50:, 2] - fall.position[50, 2], -0.5 * 9.81 * t**2, atol=1e-9)
    assert np.all(fall.wrench[50:] == 0.0)
    assert told(fall) == [(0.05, "emergency_stop"), (0.05, "power_off"), (0.05, "slack")]


def test_limits_leave_alone_what_is_known_to_be_held():
    """A jammed cable breaks undetected: the distribution still uses its last known tension."""
    found = run(
        {"type": "cable_jam", "time": 0.01, "cable": 4},
        {"type": "cable_break", "time": 0.02, "cable": 4, "detected_after": 0.05},
        {"type": "limits", "time": 0.03, "max": 9000},
    )
    assert np.all(found.tension[20:, 3] == 0.0)
    # Until detection, the previous pull of the cable is missing.
    assert found.residual[20:70] == pytest.approx(found.residual[20], rel=1e-2)


def test_without_power_a_jammed_cable_still_pulls():
    fall = run({"type": "cable_jam", "time": 0.04, "cable": 3}, {"type": "emergency_stop", "time": 0.05, "category": 0})
    assert np.all(np.delete(fall.tension[50:], 2, axis=1) == 0.0)
    assert np.all(fall.tension[50:, 2] == fall.tension[39, 2])


MOVE = {"simulation.duration": 2.0}


def moving(**changes):
    """Caroca's own move with an emergency stop in its midst."""
    overrides = {**MOVE, "events": [{"type": "emergency_stop", "time": 1.0, "stopping_time": 0.4, **changes}]}
    return cdpr.simulate(CAROCA, overrides=overrides)


def test_a_controlled_stop_ends_at_rest_on_the_path():
    plan = cdpr.simulate(CAROCA, overrides=MOVE)
    stop = moving()
    assert stop.rows[:1000].tobytes() == plan.rows[:1000].tobytes()
    # Half of the stopping time of the motion is still covered; there it stays.
    np.testing.assert_allclose(stop.desired_position[1400:], np.tile(plan.desired_position[1200], (601, 1)), atol=1e-12)
    assert not stop.rows[1400:, stop.header.layout.span("desired_velocity", "desired_angular_acceleration")].any()
    assert np.abs(stop.position_error).max() < 1e-4
    assert np.linalg.norm(stop.velocity[-1]) < 1e-4
    away = np.linalg.norm(stop.desired_position[:, None, :] - plan.desired_position[None, :, :], axis=2).min(axis=1)
    assert away.max() < 1e-3  # no point off the path, but for the distance between two samples
    assert told(stop) == [(1.0, "emergency_stop")]
    assert stop.events[0].text == "emergency stop of category 2, at rest within 0.4 s"


def test_a_controlled_stop_is_smooth():
    """Rates are the derivatives of what they belong to, and acceleration does not jump."""
    stop = moving()
    for value, rate in (("position", "velocity"), ("velocity", "acceleration"), ("angular_velocity",) * 2):
        if value == rate:
            rate = "angular_acceleration"
        x, v = stop[f"desired_{value}"], stop[f"desired_{rate}"]
        slope = (x[2:] - x[:-2]) / (2.0 * H)
        np.testing.assert_allclose(v[1:-1], slope, atol=2e-2 * H + 1e-9 if value == "position" else 2e-2)
    jumps = np.abs(np.diff(stop.desired_acceleration, axis=0)).max()
    assert jumps < 0.05  # m/s^2 from one sample to the next, of up to 4


def test_the_first_category_cuts_the_power_after_the_stop():
    stop = moving(category=1)
    assert stop.tension[1399].min() > 50.0
    assert np.all(stop.tension[1400:] == 0.0)
    assert told(stop) == [(1.0, "emergency_stop"), (1.4, "power_off"), (1.4, "slack")]


def test_a_stopping_motion_begins_and_ends():
    motion = Stopping(build(cdpr.load_scenario(CAROCA)).trajectory, 1.0, 0.4)
    assert (motion.start, motion.end) == (0.0, 1.4)
    assert not motion.sample(5.0)[7:].any()


def test_faults_reach_controllers_that_put_out_commands():
    """The stage clips nothing of a cable that is known to be broken, and the policy stop does not end the run."""
    lengths = run(break_of(2), controller="cable_length", **{"solver.infeasible": "stop"})
    assert np.all(lengths.tension[50:, 1] == 0.0)
    assert lengths.tension[49, 1] > 50.0
    np.testing.assert_allclose(lengths.wrench[60], wrench_of(lengths, 60), atol=1e-9)
    late = run(break_of(2, detected_after=0.01), controller="cable_length")
    assert np.all(late.tension[50:, 1] == 0.0)
    np.testing.assert_allclose(late.wrench[55], wrench_of(late, 55), atol=1e-9)
    intact = np.delete(late.tension[50:60], 1, axis=1)
    np.testing.assert_array_equal(late.margin[50:60], np.minimum(intact - 50.0, 10000.0 - intact).min(axis=1))
    capped = run({"type": "limits", "time": 0.05, "max": 300}, controller="cable_length")
    assert capped.tension[50:].max() == 300.0
    assert np.all(capped.solver_status[50:] == 2)


def wrench_of(run, k):
    from cdpr.mechanics.kinematics import wrench_matrix

    robot = cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
    return wrench_matrix(robot, run.rows[k, run.header.layout.span("position", "angular_velocity")]) @ run.tension[k]


@pytest.mark.parametrize("name", ["planar", "point_mass", "carriage"])
def test_guided_robots_are_pushed_along_what_is_free(name):
    path = ROOT / "scenarios" / f"{name}.yaml"
    loop = cdpr.load_scenario(path)
    rows = loop.robot.rows
    push = {"type": "wrench", "time": 0.05, "force": [5.0, 5.0, 5.0]}
    still, pushed = (run(*events, scenario=path) for events in ((), (push,)))
    change = (pushed.velocity - still.velocity)[51]
    free = [row for row in rows if row < 3]
    np.testing.assert_allclose(change[free], H * 5.0 / loop.robot.platform.mass, rtol=1e-3)
    assert not np.delete(change, free).any()


def test_early_stops_list_past_events():
    with pytest.raises(cdpr.Infeasible) as caught:
        run(
            {"type": "wrench", "time": 0.01, "force": [1, 0, 0]},
            {"type": "limits", "time": 0.02, "max": 100},
            {"type": "wrench", "time": 0.03, "force": [1, 0, 0]},
            **{"solver.infeasible": "stop"},
        )
    assert [kind for _, kind in told(caught.value.run)] == ["wrench", "limits", "infeasible"]


def test_real_time_and_the_record_on_disk(tmp_path):
    written = cdpr.simulate(
        CAROCA,
        overrides={**HOLD, "initial.position": PLACE, "events": [break_of(2), {"type": "wrench", "force": [1, 2, 3]}]},
        out=tmp_path / "run",
        real_time=True,
    )
    again = cdpr.load_run(tmp_path / "run")
    assert again.rows.tobytes() == written.rows.tobytes()
    assert again.events == written.events
    assert [event.kind for event in again.events] == ["wrench", "cable_break"]
    text = (tmp_path / "run" / "scenario.yaml").read_text()
    assert cdpr.simulate(cdpr.load_scenario("again.yaml", text=text)).rows.tobytes() == written.rows.tobytes()


@pytest.mark.parametrize("backend", installed("reference", "mujoco", "bullet", "dart"))
@pytest.mark.usual("reference", "mujoco")
def test_the_scenarios_run_on_every_backend(backend):
    """Their comments are correct."""
    broken = cdpr.simulate(ROOT / "scenarios" / "cable_break.yaml", backend=backend)
    assert np.all(broken.tension[1000:, 1] == 0.0)
    assert not broken.solver_status.any()
    error = 1e3 * np.linalg.norm(broken.position_error, axis=1)  # mm
    assert error.max() == pytest.approx(0.97, abs=0.05)  # of first order: half a step later
    assert error[-1] < 1e-3
    pushed = cdpr.simulate(ROOT / "scenarios" / "external_wrench.yaml", backend=backend)
    assert pushed.position_error[1490, 0] == pytest.approx(-0.020, rel=0.02)
    assert pushed.position_error[-1, 2] == pytest.approx(0.020, rel=0.001)
    twisted = pushed.angular_velocity[2000:4000, 2]
    assert np.ptp(twisted) > 0.1
