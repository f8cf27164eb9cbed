"""Actions during a simulation: they equal events of a scenario, and the saved scenario repeats them."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from live_cases import CAROCA, PLANNED, QUIET, SHORT, WINCH, busy, quiet, simulated
from plants import installed
from spread import sampled

import cdpr

DONE = {
    "push": (
        lambda sim: sim.push([100, 0, 0], duration=0.01),
        {"type": "wrench", "force": [100, 0, 0], "duration": 0.01},
    ),
    "step": (lambda sim: sim.push(moment=[0, 5, 0]), {"type": "wrench", "moment": [0, 5, 0]}),
    "target": (
        lambda sim: sim.target([1.0, 0.4, 1.5], [1, 0, 0, 0], duration=0.02),
        {"type": "target", "position": [1.0, 0.4, 1.5], "orientation": {"quaternion": [1, 0, 0, 0]}, "duration": 0.02},
    ),
    "cut": (lambda sim: sim.cut(2), {"type": "cable_break", "cable": 2}),
    "jam": (lambda sim: sim.jam(2, detected_after=0.004), {"type": "cable_jam", "cable": 2, "detected_after": 0.004}),
    "limits": (lambda sim: sim.limits(max=300), {"type": "limits", "max": 300}),
    "stop": (
        lambda sim: sim.stop(1, stopping_time=0.01),
        {"type": "emergency_stop", "category": 1, "stopping_time": 0.01},
    ),
    "set": (lambda sim: sim.set("controller.kp", 40), {"type": "set", "key": "controller.kp", "value": 40}),
}


@pytest.mark.parametrize("what", DONE)
def test_actions_are_events(what):
    """The same rows, to the bit, and the same messages."""
    do, event = DONE[what]
    planned = simulated({**event, "time": 0.02})
    with quiet() as sim:
        sim.step(20)
        assert do(sim).time == 0.02
        sim.step(100)
        run = sim.run()
    assert run.rows.tobytes() == planned.rows.tobytes() != simulated().rows.tobytes()
    assert run.events == planned.events
    assert run.header.broken == planned.header.broken
    assert run.summary()["tension_N"] == planned.summary()["tension_N"]


@pytest.mark.slow
@sampled(1, "backend", installed("reference", "mujoco", "bullet", "dart"))
def test_a_session_repeats_itself(backend, tmp_path):
    with cdpr.Simulation(CAROCA, backend=backend, overrides={**QUIET, **PLANNED}) as sim:
        busy(sim)
        sim.save(tmp_path / "session.yaml")
        run = sim.run()
    again = cdpr.simulate(tmp_path / "session.yaml")
    assert again.rows.tobytes() == run.rows.tobytes()
    told = [event for event in run.events if event.kind != "ended"]
    assert list(again.events) == told
    assert {event.kind for event in told} >= {"wrench", "target", "set", "outside", "cable_jam", "emergency_stop"}
    with cdpr.Simulation(tmp_path / "session.yaml") as sim:  # a session of a session
        sim.step(4, tension=np.full(8, 123.4))
        sim.save(tmp_path / "second.yaml")
        sim.step(7)
        sim.save(tmp_path / "second.yaml")
        second = sim.run()
    assert cdpr.simulate(tmp_path / "second.yaml").rows.tobytes() == second.rows.tobytes()


def test_the_command_line_repeats_it(tmp_path):
    with quiet(**PLANNED) as sim:
        busy(sim)
        sim.save(tmp_path / "session.yaml")
        run = sim.run()
    cdpr_here("run", tmp_path / "session.yaml", "--out", tmp_path / "run", "--no-report")
    assert cdpr.load_run(tmp_path / "run").rows.tobytes() == run.rows.tobytes()


@pytest.mark.slow
def test_other_commands_take_such_scenarios(tmp_path):
    """A simulation without controller or plant omits their data."""
    with quiet(**PLANNED) as sim:
        busy(sim)
        sim.save(tmp_path / "session.yaml")
    assert "set at 0.005 s" in cdpr_here("info", tmp_path / "session.yaml").stdout
    assert "ok" in cdpr_here("validate", tmp_path / "session.yaml").stdout


def test_a_branch_forgets_what_was_done_after_it():
    with quiet(**PLANNED) as sim:
        sim.step(2)
        push = sim.push([10, 0, 0])
        sim.step(3)
        here = sim.snapshot()
        busy(sim)
        sim.restore(here)
        sim.release(push)
        sim.step(100)
        run = sim.run()
    with quiet(**PLANNED) as sim:
        sim.step(2)
        push = sim.push([10, 0, 0])
        sim.step(3)
        sim.release(push)
        sim.step(100)
        assert sim.run().rows.tobytes() == run.rows.tobytes()
        assert sim.run().events == run.events


@sampled(2, "controller", ["computed_torque", "static", "pid", "cable_length"])
def test_options_go_back_with_a_snapshot(controller):
    with cdpr.Simulation(CAROCA, controller=controller, overrides=SHORT) as sim:
        sim.step(5)
        here = sim.snapshot()
        sim.set("controller.kp", 7.0)
        sim.set("controller.kd", 1.0)
        there = sim.snapshot()
        sim.step(20)
        changed = sim.row
        sim.restore(here)
        sim.step(20)
        kept = sim.row
        sim.restore(there)
        sim.step(20)
        np.testing.assert_array_equal(sim.row, changed)
    assert (kept != changed).any()
    whole = cdpr.simulate(CAROCA, controller=controller, overrides=SHORT)
    np.testing.assert_array_equal(kept, whole.rows[24])


def test_a_push_that_is_released_at_once_was_none():
    with quiet() as sim:
        sim.step(4)
        sim.release(sim.push([1e3, 0, 0]))
        sim.step(100)
        assert sim.run().rows.tobytes() == simulated().rows.tobytes()


def test_a_target_takes_the_motion_along():
    """No jump in position, velocity or acceleration, at rest in the target when the time is over."""
    with cdpr.Simulation(CAROCA, overrides={"simulation.duration": 2.0}) as sim:
        sim.until(1.0)
        sim.target([0.2, 0.1, 1.3], {"rpy": [0, 0, 0.1]}, duration=0.5)
        before = sim.desired
        sim.until(2.0)
        run = sim.run()
    k, h = 1000, 1e-3
    np.testing.assert_allclose(before, cdpr.load_scenario(CAROCA).trajectory.make().sample(1.0), rtol=0, atol=1e-12)
    for name, rate in (("desired_position", "desired_velocity"), ("desired_velocity", "desired_acceleration")):
        slope = np.diff(run[name][k - 5 : k + 6], axis=0) / h
        np.testing.assert_allclose(slope, 0.5 * (run[rate][k - 5 : k + 5] + run[rate][k - 4 : k + 6]), atol=2e-4)
    np.testing.assert_allclose(run.desired_position[-1], [0.2, 0.1, 1.3], atol=1e-12)
    np.testing.assert_allclose(run.desired_orientation[-1], [np.cos(0.05), 0, 0, np.sin(0.05)], atol=1e-12)
    assert not run.desired_velocity[1502:].any()


@pytest.mark.parametrize("time", [0.0, 0.1, 1.0])
def test_targets_repeat_wherever_the_motion_is(time, tmp_path):
    """Before it begins, at its start, on its way; at a slant, stopped in the midst of it."""
    overrides = {"simulation.duration": 1.5, "trajectory.start": 0.5, "initial.orientation": {"rpy": [0.1, -0.2, 3.0]}}
    with cdpr.Simulation(CAROCA, overrides=overrides) as sim:
        sim.until(time)
        sim.target(np.add(sim.desired[:3], [0.01, 0.0, 0.02]), duration=0.3)
        sim.until(time + 0.2)
        sim.stop(1, stopping_time=0.1)
        sim.step(1500)
        sim.save(tmp_path / "session.yaml")
        assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == sim.run().rows.tobytes()


@pytest.mark.parametrize("step", [1 / 3000, 0.0007, 0.01])
def test_any_control_step_repeats(step, tmp_path):
    """An action at a sample stays there, after events that the scenario plans a rounding error later."""
    planned = [{"type": "limits", "time": 7 * step * (1 + 1e-10), "cable": 4, "max": 300}]
    steps = {"simulation.control_step": step, "simulation.physics_step": step, "simulation.duration": 40 * step}
    with quiet(**steps, events=planned) as sim:
        sim.step(7)
        sim.cut(2)
        sim.jam(3)
        sim.limits(min=60)
        sim.step(6)
        push = sim.push([3, 0, 0])
        sim.step(9)
        sim.release(push)
        sim.step(3, wrench=[0, 0, 1400, 0, 0, 0])
        sim.stop(1, stopping_time=5 * step)
        sim.step(100)
        sim.save(tmp_path / "session.yaml")
        assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == sim.run().rows.tobytes()


def test_limits_of_a_target_are_kept_and_used():
    limits, angular = (
        {"velocity": 1.0, "acceleration": 4.0, "jerk": 40.0},
        {"velocity": 9, "acceleration": 9, "jerk": 99},
    )
    overrides = {"simulation.duration": 2.0}
    for start in (0.0, 1.0):  # from rest, and on the way
        with cdpr.Simulation(CAROCA, overrides=overrides) as sim:
            if start:
                sim.until(start)
            sim.target([0.6, 0.0, 1.2], limits=limits, angular_limits=angular)
            sim.until(2.0)
            run = sim.run()
        part = run.time >= start
        jerk = np.diff(run.desired_acceleration[part], axis=0) / 1e-3
        values = run.desired_velocity[part], run.desired_acceleration[part], jerk[:-1]
        shares = [np.linalg.norm(v, axis=1).max() / limit for v, limit in zip(values, limits.values(), strict=True)]
        assert 0.99 < max(shares) <= 1.0


MISUSE = {
    "unknown cable": (lambda sim: sim.cut("lift"), r"^cut: cable: unknown cable 'lift': .*allowed: "),
    "ninth cable": (lambda sim: sim.jam(9), r"^jam: cable: cables are numbered from 1 to 8, got 9"),
    "cable of another kind": (lambda sim: sim.cut(2.5), r"^cut: cable: "),
    "no cable": (lambda sim: sim.cut(None), r"^cut: cable: required"),
    "cut twice": (lambda sim: sim.cut(3), r"^cut: cable '\w+' is broken already, since 0\.002 s"),
    "jam what is cut": (lambda sim: sim.jam(3), "is broken already"),
    "limits of what is cut": (lambda sim: sim.limits(1, cable=3), "is broken already"),
    "no limits": (lambda sim: sim.limits(), r"^limits: min or max is missing"),
    "upside down": (lambda sim: sim.limits(500, 400), r"^limits: cable '\w+' would have the limits 500 to 400"),
    "negative": (lambda sim: sim.limits(-5), "a cable cannot push"),
    "no force": (lambda sim: sim.push([1, 2]), r"^push: force: the shape must be \(3,\)"),
    "nan": (lambda sim: sim.push([np.nan, 0, 0]), r"^push: force: all numbers must be finite"),
    "words": (lambda sim: sim.push("hard"), r"^push: force: "),
    "huge": (lambda sim: sim.push([1e300, 0, 0]), r"^push: force\[0\]: must lie between"),
    "short push": (lambda sim: sim.push([1, 0, 0], duration=1e-5), r"^push: duration: must be at least control_step"),
    "endless push": (lambda sim: sim.push([1, 0, 0], duration=np.inf), r"^push: duration: "),
    "release of nothing": (
        lambda sim: sim.release(None),
        r"^release: expected a value that `push` or .* returned",
    ),
    "no target": (lambda sim: sim.target(duration=1), r"^target: position \(m\), orientation, or both are required"),
    "no pace": (lambda sim: sim.target([0, 0, 1]), r"^target: expected either duration \(s\) or limits"),
    "both paces": (
        lambda sim: sim.target([0, 0, 1], duration=1, limits={"velocity": 1, "acceleration": 1, "jerk": 1}),
        "not both",
    ),
    "jump": (lambda sim: sim.target([0, 0, 1], duration=1e-6), "or it is a jump"),
    "limits that lack": (lambda sim: sim.target([0, 0, 1], limits={"velocity": 1}), r"^target: limits\.acceleration: "),
    "turning": (
        lambda sim: sim.target(orientation={"rpy": [0, 0, 1]}, limits={"velocity": 1, "acceleration": 1, "jerk": 1}),
        r"^target: event 'target' at 0\.003 s: angular_limits are required",
    ),
    "attitude": (lambda sim: sim.target(orientation=[0, 0, 0, 0], duration=1), "the quaternion is zero"),
    "category": (lambda sim: sim.stop(3), r"^stop: category: must be at most 2, got 3"),
    "no option": (lambda sim: sim.set("controller.kq", 1), r"^set: key: 'controller.kq' cannot change.*did you mean"),
    "solver": (lambda sim: sim.set("solver.p", 1), r"allowed: controller\.kp, controller\.kd"),
    "gain": (lambda sim: sim.set("controller.kp", -1), r"^set: value: "),
    "gains": (lambda sim: sim.set("controller.kp", [1, 2]), r"^set: value: "),
    "key": (lambda sim: sim.set(3, 1), r"^set: key: expected a text"),
    "value": (lambda sim: sim.set("controller.kp", print), r"^set: .*got builtin_function_or_method"),
    "no name": (lambda sim: sim.save(5), r"^save: expected the name of a file"),
    "wrong name": (lambda sim: sim.save("session.txt"), "ends in .yaml"),
    "itself": (lambda sim: sim.save(CAROCA), "is the scenario that is simulated"),
    "nowhere": (lambda sim: sim.save("/nowhere/session.yaml"), "/nowhere"),
    "later": (lambda sim: sim.stop(), r"^stop: event 'target' at 0\.03 s could not happen then: the robot is stopped"),
}
LATER = {"events": [{"type": "target", "time": 0.03, "position": [1, 0.3, 1.51], "duration": 0.01}]}


def played(misuse=None, text=""):
    with quiet(**LATER) as sim:
        sim.step(2)
        sim.cut(3)
        sim.step(1)
        if misuse:
            with pytest.raises(cdpr.CdprError, match=text):
                misuse(sim)
        sim.step(100)
        return sim.run()


@pytest.fixture(scope="module")
def undisturbed():
    return played()


@pytest.mark.parametrize("case", MISUSE)
def test_misuse_is_one_clear_error_and_nothing_has_happened(case, undisturbed):
    run = played(*MISUSE[case])
    assert run.rows.tobytes() == undisturbed.rows.tobytes()
    assert run.events == undisturbed.events


def test_a_plant_that_cannot_refuses():
    with cdpr.Simulation(WINCH, overrides=SHORT) as sim:
        sim.step(3)
        for call in (lambda: sim.cut(1), lambda: sim.jam(1)):
            with pytest.raises(
                cdpr.CdprError, match=r"^\w+: type: happens to ideal cables only, and robot.cable.model"
            ):
                call()
        sim.push([10, 0, 0], duration=0.01)
        sim.step(1)
        assert sim.run().external[-1, 0] == 10.0


def test_motions_in_held_directions_are_rejected():
    with cdpr.Simulation(str(ROOT / "scenarios" / "planar.yaml"), overrides={"simulation.duration": 0.05}) as sim:
        sim.step(1)
        with pytest.raises(cdpr.CdprError, match=r"^target: .*the robot moves along"):
            sim.target([0.0, 0.1, 1.2], duration=1.0)


def test_at_the_start_and_at_the_end():
    event = {"type": "wrench", "time": 0, "force": [50, 0, 0]}
    with quiet() as sim:
        sim.push([50, 0, 0])
        with pytest.raises(cdpr.CdprError, match=r"^jam: time: must be greater than 0"):
            sim.jam(1)
        sim.step(100)
        for call in (lambda: sim.push([1, 0, 0]), sim.stop, lambda: sim.set("controller.kp", 1)):
            with pytest.raises(cdpr.CdprError, match="the simulation is done"):
                call()
        assert sim.run().rows.tobytes() == simulated(event).rows.tobytes()
        with pytest.raises(cdpr.CdprError, match="the simulation is over"):
            sim.cut(1)
