"""The controller `tension_feedback`: its law, and the wrench of cables on pulleys with friction."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from plants import installed
from restarts import assert_restarts_give

import cdpr
from cdpr.base.errors import CdprError
from cdpr.mechanics import kinematics
from cdpr.simulation.exported import control_of

SCENARIOS = ROOT / "scenarios"
CELLS = [{"type": "tension"}]
NOISY = [{"type": "tension", "name": "cells", "tension": {"noise": 0.5, "gain": 1.002}, "delay": 0.003}]
FEEDBACK = {"type": "tension_feedback"}
PULLEY = {"robot.cable.exit": {"type": "pulley", "radius": 0.1, "friction": 0.1}}
TWENTY_PERCENT = {"cogiro_pulleys": 0.106, "caroca": 0.096, "pick_and_place": 0.09}  # coefficients of the grooves
HALF = 0.5  # of the error of the wrench without feedback
STEP = 0.001  # s
ROUND_OFF = 1e-9  # N, of tensions of the order of 1e3


def simulate(name, overrides=None, **more):
    return cdpr.simulate(
        SCENARIOS / f"{name}.yaml", overrides={"controller": FEEDBACK, "sensors": CELLS} | (overrides or {}), **more
    )


def wrench_error(run, robot):
    """Norm (K,), N, of the wrench of the cables minus the required one; moments over the characteristic length."""
    states = np.hstack([run.position, run.orientation, run.velocity, run.angular_velocity])
    exerted = np.array(
        [kinematics.wrench_matrix(robot, s) @ t for s, t in zip(states, run["cable_tension"], strict=True)]
    )
    return np.linalg.norm((exerted - run.wrench) / np.repeat([1.0, robot.characteristic_length], 3), axis=1)


def test_the_log_follows_the_law():
    options = FEEDBACK | {"gain": 0.3, "integral_gain": 40.0, "integral_limit": 20.0}
    run = simulate("caroca", {"controller": options, "sensors": NOISY, **PULLEY, "simulation.duration": 1.0})
    z, low, high = np.zeros(8), 50.0, 10000.0
    limited = 0
    for k, time in enumerate(run.time):
        wanted, taken = run["distributed_tension"][k], time - run["cells_age"][k, ...].item()
        error = wanted - run["cells_tension"][k] if taken > 0.5 * STEP else np.zeros(8)
        grown = np.clip(z + 40.0 * STEP * error, -20.0, 20.0)
        outside = wanted + 0.3 * error + grown
        stuck = ((outside > high) & (error > 0) | (outside < low) & (error < 0)) & (z * error >= 0)
        z = np.where(stuck, z, grown)
        limited += np.count_nonzero(np.abs(z) == 20.0)
        expected = np.clip(wanted + 0.3 * error + z, low, high)
        np.testing.assert_allclose(run.tension[k], expected, atol=ROUND_OFF, err_msg=f"sample {k}")
    assert limited > 100
    assert run.interpreted == ()
    robot = cdpr.load_scenario(SCENARIOS / "caroca.yaml", overrides=PULLEY).robot
    W = kinematics.wrench_matrix(robot, np.concatenate([run.position[-1], run.orientation[-1], np.zeros(6)]))
    np.testing.assert_allclose(W @ run["distributed_tension"][-1], run.wrench[-1], atol=1e-6)


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
@pytest.mark.parametrize("name", list(TWENTY_PERCENT))
def test_it_halves_the_error_of_the_wrench_under_friction(name, backend):
    """Cables lose up to 20 % of their tension on the pulleys."""
    changes = {"simulation.backend": backend, "controller": {"type": "computed_torque"}, "sensors": CELLS}
    changes |= {**PULLEY, "robot.cable.exit.friction": TWENTY_PERCENT[name]}
    robot = cdpr.load_scenario(SCENARIOS / f"{name}.yaml", overrides=changes).robot
    without = simulate(name, changes)
    loss = np.abs(1.0 - np.minimum(r := without["cable_tension"] / without["winch_tension"], 1.0 / r)).max()
    assert loss == pytest.approx(0.2, abs=0.02)
    run = simulate(name, changes | {"controller": FEEDBACK})
    before, after = (wrench_error(each, robot) for each in (without, run))
    assert np.sqrt(np.mean(after**2)) < HALF * np.sqrt(np.mean(before**2))
    assert after.max() < HALF * before.max()
    errors = [np.linalg.norm(each.position_error, axis=1).max() for each in (run, without)]
    assert errors[0] < HALF * errors[1]


def test_before_a_measurement_it_sends_the_distributed_tensions():
    """At time 0 load cells show no tension; with a delay they do so for longer."""
    late = simulate("caroca", {"sensors": [{"type": "tension", "delay": 0.005}], **PULLEY, "simulation.duration": 0.02})
    assert np.array_equal(late.tension[:6], late["distributed_tension"][:6])
    assert not np.array_equal(late.tension[6], late["distributed_tension"][6])


def test_exact_cells_on_ideal_cables_change_nothing_at_rest():
    held = {"trajectory": {"type": "hold"}, "simulation.duration": 0.5}
    run, plain = simulate("caroca", held), simulate("caroca", held | {"controller": {"type": "computed_torque"}})
    np.testing.assert_allclose(run.tension, plain.tension, atol=ROUND_OFF)


@pytest.mark.parametrize("backend", installed("reference", "bullet"))
def test_snapshots_and_resets_contain_the_integrals(backend):
    overrides = {"controller": FEEDBACK, "sensors": NOISY, **PULLEY, "simulation.duration": 0.05}
    overrides |= {"simulation.backend": backend}
    scenario = str(SCENARIOS / "caroca.yaml")
    assert_restarts_give(cdpr.simulate(scenario, overrides=overrides).rows.tobytes(), scenario, overrides)


def test_rollouts_have_the_bits_of_single_runs():
    gains = [0.1 * k for k in range(9)]
    overrides = {"controller.type": "tension_feedback", "sensors": NOISY, **PULLEY, "simulation.duration": 0.05}
    columns = ["position", "tension", "distributed_tension"]
    vary = {"controller.gain": gains, "simulation.seed": list(range(9))}
    batch = cdpr.rollout(SCENARIOS / "caroca.yaml", 9, vary=vary, overrides=overrides, columns=columns)
    for i in (0, 4, 8):
        own = {"controller.gain": gains[i], "simulation.seed": i}
        single = cdpr.simulate(SCENARIOS / "caroca.yaml", overrides={**overrides, **own})
        assert all(batch[name][i].tobytes() == np.ascontiguousarray(single[name]).tobytes() for name in columns)


def test_a_wrench_from_outside_passes_the_inner_loop_and_tensions_do_not():
    overrides = {"controller": FEEDBACK, "sensors": CELLS, **PULLEY, "simulation.duration": 0.05}
    with cdpr.Simulation(SCENARIOS / "caroca.yaml", overrides=overrides) as simulation:
        simulation.step(10, wrench=[200.0, 0.0, 150.0 * 9.81, 0.0, 0.0, 0.0])
        simulation.step(10, tension=np.full(8, 300.0))
        run = simulation.run()
    assert np.abs(run.tension[1:10] - run["distributed_tension"][1:10]).max() > 0.1
    assert np.array_equal(run.tension[10:20], np.full((10, 8), 300.0))


def test_the_policy_hold_tension_holds_the_distributed_tensions():
    """The correction does not add to itself while no tensions balance the wrench."""
    push = [{"type": "wrench", "time": 0.02, "force": [0.0, 0.0, 1e6]}]
    changes = {**PULLEY, "solver.infeasible": "hold_tension", "events": push, "simulation.duration": 0.06}
    run = simulate("caroca", {**changes, "controller": FEEDBACK | {"integral_gain": 0.0, "kp": 1e5}})
    failed = np.flatnonzero(run.solver_status)
    assert len(failed) > 5
    held = run["distributed_tension"][failed]
    assert np.array_equal(held, np.broadcast_to(held[0], held.shape))
    error = held - run["tension_tension"][failed]
    np.testing.assert_allclose(run.tension[failed], np.clip(held + 0.5 * error, 50.0, 10000.0), atol=ROUND_OFF)


def test_a_broken_cable_keeps_its_imposed_tension():
    run = simulate("cable_break", {"simulation.duration": 4.0})
    broken = int(np.argmin(run.tension[-1]))
    assert run.tension[-1, broken] == 0.0
    np.testing.assert_allclose(run.tension[-1], run["distributed_tension"][-1], atol=1e-3)  # N: it rests
    assert run.status == "finished"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensors": []}, r"needs measured tensions: add \{type: tension\} to `sensors`"),
        ({"controller.sensor": "other"}, "has the name 'other': expected tension"),
        ({"controller.gain": (1.0, 2.0)}, "gain has 2 values, the robot 8 cables"),
    ],
)
def test_errors_name_the_remedy(changes, message):
    with pytest.raises(CdprError, match=message):
        simulate("caroca", changes)


def test_it_cannot_be_exported():
    overrides = {"controller": FEEDBACK, "sensors": CELLS}
    scenario = cdpr.load_scenario(SCENARIOS / "caroca.yaml", overrides=overrides)
    with pytest.raises(CdprError, match="measurements"):
        control_of(scenario, "bare_controller_fmu")
