"""Emergency stops of winches with brakes against integrations of the docstring's equations, and their messages."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import cdpr_here
from log_cases import same_bits
from plants import installed
from scipy.integrate import solve_ivp

import cdpr

MASS, GRAVITY, RADIUS, INERTIA, FRICTION = 20.0, 9.81, 0.05, 0.05, 0.2  # kg, m/s^2, m, kg m^2, N m s
STIFFNESS, DAMPING, TOP = 4e5, 800.0, 3.0  # N, N s/m, m
LOAD = MASS * GRAVITY * RADIUS  # N m, 9.81
SERVO = {"type": "position", "drum_radius": RADIUS, "inertia": INERTIA, "viscous_friction": FRICTION}
SERVO |= {"position_gain": 40.0, "velocity_gain": 10.0, "integral_gain": 50.0}
TORQUE = {"drum_radius": RADIUS, "inertia": INERTIA, "viscous_friction": FRICTION}
STEPPER = TORQUE | {"type": "stepper", "stall_torque": 40.0, "microsteps": 64}
CUT = 0.5  # s


def hoist(winch, event, **changes):
    """Return a mass on one cable that is lowered by 1 m within a second, and an emergency stop in the middle."""
    data = {
        "robot": {
            "dof": ["z"],
            "platform": {"mass": MASS},
            "tension": {"min": 0, "max": 2000},
            "home": {"position": [0.0, 0.0, 1.0]},
            "cable": {"model": "elastic", "axial_stiffness": STIFFNESS, "damping": DAMPING},
            "winch": winch,
            "cables": [{"frame": [0.0, 0.0, TOP], "platform": [0, 0, 0]}],
        },
        "simulation": {"backend": "reference", "duration": 1.5, "control_step": 0.002, "physics_step": 0.0002},
        "trajectory": {"type": "quintic", "duration": 1.0, "to": {"position": [0.0, 0.0, 0.0]}},
        "controller": {"type": "inverse_kinematics" if "type" in winch else "computed_torque"},
        "events": [{"type": "emergency_stop", "time": CUT, **event}],
    }
    return cdpr.load_scenario(data, overrides=changes)


def coasted(run, delay, brake, end, inertia=INERTIA):
    """Return height and unwound length after the power cut, by adaptive steps that end where the drum stops."""
    k = round(CUT / 0.002)
    state = [run.position[k, 2], run.velocity[k, 2], *(run[name][k, 0] for name in UNWOUND)]

    def slope(_, y, torque, sign):
        height, velocity, unwound, paying = y
        stretch, rate = TOP - height - unwound, -velocity - paying
        tension = max(STIFFNESS * stretch / unwound + DAMPING * rate, 0.0) if stretch > 0.0 else 0.0
        free = RADIUS * tension - FRICTION * paying / RADIUS  # N m, paying out
        turning = (free - torque * sign) / inertia * RADIUS if sign else 0.0
        return [velocity, tension / MASS - GRAVITY, paying, turning]

    options = {"rtol": 1e-10, "atol": 1e-12, "max_step": 1e-3}

    def stops(_, y, *given):
        return y[3]

    stops.terminal, stops.direction = True, -1
    time = CUT
    if delay:
        state = solve_ivp(slope, (time, time + delay), state, args=(0.0, 1.0), **options).y[:, -1]
        time += delay
    found = solve_ivp(slope, (time, end), state, args=(brake, 1.0), events=stops, **options)
    if found.status == 1 and brake > LOAD:
        rest = [*found.y[:3, -1], 0.0]
        found = solve_ivp(slope, (found.t[-1], end), rest, args=(brake, 0.0), **options)
    return found.y[0, -1], found.y[2, -1]


UNWOUND = ("unstretched_length", "unstretched_rate")
BRAKE = {"brake_torque": 25.0, "brake_delay": 0.06}


@pytest.mark.parametrize("winch", [SERVO, STEPPER], ids=["servo", "stepper"])
@pytest.mark.parametrize("brake", [BRAKE, {"brake_torque": 60.0}], ids=["late", "at once"])
def test_a_power_cut_of_category_0(winch, brake):
    """The load accelerates until the brakes close, and slides until they have stopped it."""
    run = cdpr.simulate(hoist(winch | brake, {"category": 0}))
    height, unwound = coasted(run, brake.get("brake_delay", 0.0), brake["brake_torque"], 1.5)
    assert run.position[-1, 2] == pytest.approx(height, abs=2e-5)
    assert run["unstretched_length"][-1, 0] == pytest.approx(unwound, abs=2e-5)
    assert run.position[250, 2] - height > (0.1 if "brake_delay" in brake else 0.01)  # m, stopping distance
    assert (run["unstretched_rate"][-100:] == 0.0).all()
    assert not run.motor_torque[251:].any()
    assert not run.motor_power[251:].any()
    assert run.cable_tension[-1, 0] == pytest.approx(MASS * GRAVITY, rel=1e-3)
    assert run.summary()["energy_J"]["balanced"]
    assert [event.kind for event in run.events if event.time >= CUT][:2] == ["emergency_stop", "power_off"]


def test_drives_apply_commands_of_winches_without_power():
    """Only tensions become 0."""
    run = cdpr.simulate(hoist(SERVO | BRAKE, {"category": 0}, drives={"delay": 0.004}))
    assert run.drive_command[-1, 0] == run.winch_command[-1, 0] > 0.1
    assert not run.motor_power[260:].any()


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_a_brake_of_any_strength_only_stops(backend):
    """It turns no drum back, in no stage of a step, so all strong brakes end in the same place."""
    ends = []
    for torque in (1e5, 1e6, 1e8):
        brake = {"brake_torque": torque}
        run = cdpr.simulate(hoist(SERVO | brake, {"category": 0}, **{"simulation.backend": backend}))
        after = run.time >= CUT
        assert (np.diff(run["unstretched_length"][after, 0]) >= 0.0).all()  # it was paid out
        ends.append(run.position[-1, 2])
    assert np.ptp(ends) < 1e-6


def test_a_weak_brake_slides():
    """With constant acceleration (m g r - M_b - f) / (m r^2 + I) r, after viscous friction limits it."""
    run = cdpr.simulate(hoist(SERVO | {"brake_torque": 8.0}, {"category": 0}, **{"simulation.duration": 0.9}))
    height, unwound = coasted(run, 0.0, 8.0, 0.9)
    assert run.position[-1, 2] == pytest.approx(height, abs=2e-4)
    assert run["unstretched_rate"][-1, 0] > 0.1
    assert run["unstretched_length"][-1, 0] == pytest.approx(unwound, abs=2e-4)


@pytest.mark.parametrize("winch", [SERVO, STEPPER, {"type": "position"}, {"type": "velocity"}])
@pytest.mark.parametrize("category", [1, 2])
def test_controlled_stops(winch, category):
    """Along the path: half of the stopping time at full speed; then brakes or drives hold the length."""
    stop = {"category": category, "stopping_time": 0.2}
    if winch.get("type") == "velocity":
        winch = winch | {"drum_radius": RADIUS}
    changes = {} if winch.get("type") != "velocity" else {"controller": {"type": "computed_torque", "kp": 400.0}}
    run = cdpr.simulate(hoist(winch | {"brake_torque": 30.0}, stop, **changes))
    expected = 0.5 - 1.875 * 0.1  # m; peak speed of the quintic 1.875 m/s, which falls slightly along the path
    assert run.desired_position[-1, 2] == pytest.approx(expected, abs=0.01)
    assert run.position[-1, 2] == pytest.approx(run.desired_position[-1, 2], abs=0.01)
    held = np.ptp(run["unstretched_length"][-100:, 0])
    assert held < (1e-12 if category == 1 else 1e-4)
    assert run.cable_tension[-1, 0] == pytest.approx(MASS * GRAVITY, rel=1e-3)


def test_a_power_cut_of_ideal_drives_holds_their_length():
    run = cdpr.simulate(hoist({"type": "position", "brake_torque": 1.0}, {"category": 0}))
    assert np.ptp(run["unstretched_length"][251:, 0]) == 0.0
    assert np.ptp(run.position[250:, 2]) > 0.0  # the load swings on its cable


def test_brakes_of_torque_winches():
    """Without a brake the load falls, with the friction of its drum alone."""
    event = {"category": 0}
    free, held = (cdpr.simulate(hoist(TORQUE | brake, event)) for brake in ({}, {"brake_torque": 30.0}))
    assert same_bits(free.position[:251], held.position[:251])
    assert held.velocity[-1, 2] == pytest.approx(0.0, abs=1e-4)
    assert held.position[-1, 2] > 0.3
    assert free.position[-1, 2] < -0.5
    without = cdpr.simulate(hoist(TORQUE | {"brake_torque": 30.0}, {"category": 2}))
    assert same_bits(without.position, cdpr.simulate(hoist(TORQUE, {"category": 2})).position)


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
def test_engines_agree_with_the_reference(backend):
    scenario = hoist(SERVO | BRAKE, {"category": 0}, **{"backend_options.reference.scheme": "semi_implicit_euler"})
    ours, theirs = (cdpr.simulate(scenario, backend=each) for each in ("reference", backend))
    assert np.abs(ours.position - theirs.position).max() < 1e-10
    height, _ = coasted(ours, 0.06, 25.0, 1.5)
    assert ours.position[-1, 2] == pytest.approx(height, abs=1e-3)


def test_snapshots_and_rollouts_repeat_the_run():
    scenario = hoist(SERVO | BRAKE, {"category": 0})
    run = cdpr.simulate(scenario)
    for middle in (240, 260, 300):
        with cdpr.Simulation(scenario) as simulation:
            simulation.step(middle)
            moment = simulation.snapshot()
            simulation.step(100)
            simulation.restore(moment)
            simulation.step(100)
            assert same_bits(simulation.state[:3], run.position[middle + 100])
    found = cdpr.rollout(scenario, 2, vary={"robot.platform.mass": [MASS, 30.0]}, columns=["position"], threads=1)
    assert same_bits(found["position"][0][-1], run.position[-1])


def test_a_live_stop_uses_the_brakes():
    scenario = hoist(SERVO | BRAKE, {"category": 2, "stopping_time": 1.0})
    expected = cdpr.simulate(hoist(SERVO | BRAKE, {"category": 0}))
    scenario = cdpr.load_scenario(scenario, overrides={"events": []})
    with cdpr.Simulation(scenario) as simulation:
        simulation.step(250)
        simulation.stop(0)
        simulation.step(400)
        assert same_bits(simulation.state[:3], expected.position[650])
        simulation.reset()  # the brakes are released
        simulation.step(250)
        assert same_bits(simulation.state[:3], expected.position[250])


MESSAGES = {
    "no brake": (SERVO, {"category": 0}, "a power cut needs a brake of each winch that holds a length, and "),
    "delay": (SERVO | {"brake_delay": 0.1}, {}, "robot.winch.brake_delay: delay of a brake, and the winch has none"),
    "inertia": (
        {"type": "position", "brake_torque": 5.0, "brake_delay": 0.1},
        {},
        "robot.winch.brake_delay: must be 0 without an inertia",
    ),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages(name):
    winch, event, text = MESSAGES[name]
    with pytest.raises(cdpr.CdprError) as caught:
        hoist(winch, event)
    assert text in str(caught.value)


@pytest.mark.parametrize("backend", ["fmu", "remote"])
def test_a_power_cut_needs_a_backend_with_brakes(tmp_path, backend):
    """The file is rejected before a run, with the line of the power cut."""
    options = {"fmu": {}, "remote": {"address": "127.0.0.1:9"}}[backend]
    changes = {"simulation.backend": backend, f"backend_options.{backend}": options}
    file = tmp_path / "s.yaml"
    file.write_text(hoist(SERVO | BRAKE, {"category": 0}, **changes).resolved_yaml())
    line = next(k for k, text in enumerate(file.read_text().splitlines(), 1) if "category: 0" in text)
    checked = cdpr_here("validate", file.name, cwd=tmp_path, code=None)
    assert checked.returncode
    expected = (
        f"s.yaml:{line}:13: events[0].category: backend '{backend}', with its options, does not support features: "
    )
    assert checked.stderr == f"{expected}brakes: choose another backend, or remove the section\n"
    for winch, category in ((SERVO | BRAKE, 2), (TORQUE, 0)):  # no brake closes
        file.write_text(hoist(winch, {"category": category}, **changes).resolved_yaml())
        assert "brakes" not in cdpr_here("validate", file.name, cwd=tmp_path).stderr


def test_a_brake_needs_a_cable_that_stretches():
    with pytest.raises(
        cdpr.CdprError, match=r"brake_torque: a brake needs a cable that stretches, got cable.model rigid"
    ):
        hoist(TORQUE | {"brake_torque": 5.0}, {}, **{"robot.cable.model": "rigid"})
