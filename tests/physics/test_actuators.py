"""Winches as an FMU before a plant: against the native elastic cables, in its step, and where it must refuse."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from plants import installed, plant
from scipy.integrate import solve_ivp
from winch_oracle import HELD, on_winches

import cdpr
from cdpr import distribute
from cdpr.base.errors import CdprError
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.stability import longest, oscillator, stable
from cdpr.simulation.build import build
from cdpr.testing import samples

pytest.importorskip("fmpy")

SAME_PEAK = 0.01  # of the peak at a tenth of the step; measured 0.16 % on reference, 0.19 % on mujoco
PUSHED = {
    "trajectory": {"type": "hold"},
    "events": [{"type": "wrench", "force": [150, 100, 200], "moment": [20, -15, 10]}],
    "simulation.duration": 0.3,
}
PLANTS = ["reference", *installed("mujoco")]


def run(scenario, backend, **overrides):
    return cdpr.simulate(ROOT / "scenarios" / scenario, backend=backend, overrides={**PUSHED, **overrides})


def peak(run):
    return np.linalg.norm(run.position - run.position[0], axis=1).max()


@pytest.mark.parametrize("backend", PLANTS)
@pytest.mark.usual("reference")
def test_step_of_1_ms_is_within_a_percent_of_a_tenth(backend):
    """Under a step of force, and near what cables inside the plant give: finite is not enough."""
    coarse, fine = (run("winch_fmu.yaml", backend, **{"simulation.physics_step": step}) for step in (1e-3, 1e-4))
    native = run("winch.yaml", "reference", **{"simulation.physics_step": 1e-4})
    assert peak(fine) > 1e-3
    assert peak(coarse) == pytest.approx(peak(fine), rel=SAME_PEAK)
    assert peak(fine) == pytest.approx(peak(native), rel=SAME_PEAK)
    errors = [np.abs(one.position - native.position).max() for one in (coarse, fine)]
    assert errors[1] < 0.2 * errors[0] < 1e-4
    swing = np.abs(native.cable_tension - native.tension).max()
    assert np.abs(coarse.cable_tension - native.cable_tension).max() < 0.2 * swing
    assert np.abs(coarse.energy_residual).max() < 1e-3 * np.abs(coarse.cable_work).max()


def test_series_follows_the_commands_alone():
    """Without feedback a drum pulls on a cable of the length that it had: two equations, solved anew, without delay."""
    scenario = cdpr.load_scenario(
        ROOT / "scenarios" / "winch_fmu.yaml",
        backend="reference",
        overrides={"actuators.coupling": "series", "robot.winch.coulomb_friction": 0.0, "robot.cable.damping": 0.0},
    )
    backend = build(scenario).backend
    robot, told = scenario.robot, np.empty(8)
    cable, winch = robot.cables[0], robot.cables[0].winch
    length = lengths(robot, scenario.initial.state())[0]
    backend.command[:] = 300.0
    backend.step(1)
    backend.read_tension(told)
    np.testing.assert_allclose(told, 300.0, rtol=0, atol=1e-9)
    backend.command[:] = 360.0

    def slope(_, y):
        tension = cable.axial_stiffness * (length - y[0]) / y[0]
        torque = winch.drum_radius * (360.0 - tension) - winch.viscous_friction * y[1]
        return [-winch.drum_radius * y[1], torque / winch.inertia]

    y = solve_ivp(slope, (0, 0.02), [length / (1 + 300.0 / cable.axial_stiffness), 0.0], rtol=1e-10, atol=1e-12)
    backend.step(20)
    backend.read_tension(told)
    expected = cable.axial_stiffness * (length - y.y[0, -1]) / y.y[0, -1]
    assert told[0] == pytest.approx(expected, abs=0.01)
    assert abs(expected - 300.0) > 5.0
    backend.close()


def test_runs_record_their_winches(tmp_path):
    overrides = {**PUSHED, "simulation.duration": 0.05}
    cdpr.simulate(ROOT / "scenarios" / "winch_fmu.yaml", backend="reference", overrides=overrides, out=tmp_path / "run")
    told = json.loads((tmp_path / "run" / "run.json").read_text())["plugins"]["backend"]["actuators"]
    assert told["coupling"] == "gauss_seidel"
    assert told["step_omega"] == pytest.approx(0.174, abs=0.002)
    assert told["mapping"]["role"] == "winch"
    again = cdpr.load_run(tmp_path / "run")
    assert again.header.cable_model == "fmu"
    assert np.abs(again.cable_tension - again.tension).max() > 0.1


def test_unstable_steps_are_rejected_by_default():
    """Much friction about rest: the classical scheme inside the FMU cannot follow it at 1 ms."""
    stiff = {"robot.winch.coulomb_friction": 1.0}
    with pytest.raises(CdprError, match=r"step by step, is unstable.*step \* omega = 0\.174, stable up to 0\.000"):
        run("winch_fmu.yaml", "reference", **stiff)
    with pytest.raises(CdprError, match="physics_step"):
        run("winch.yaml", "reference", **stiff)
    unchecked = run("winch_fmu.yaml", "reference", **stiff, **{"actuators.check_step": False})
    assert unchecked.status == "finished"


def test_winches_need_their_values():
    with pytest.raises(CdprError, match=r"actuators: without a file .* no winch"):
        cdpr.simulate(ROOT / "scenarios" / "caroca.yaml", overrides={"actuators": {"coupling": "gauss_seidel"}})


def test_a_broken_cable_needs_ideal_ones():
    broken = {"events": [{"type": "cable_break", "time": 0.1, "cable": 1}]}
    for scenario, reason in (("winch.yaml", "robot.cable.model is elastic"), ("winch_fmu.yaml", "actuators")):
        with pytest.raises(CdprError, match=f"ideal cables only.*{reason}"):
            cdpr.load_scenario(ROOT / "scenarios" / scenario, overrides=broken)


@pytest.mark.parametrize("semi_implicit", [True, False])
@pytest.mark.parametrize("damping", [0.0, 200.0])
def test_limits_of_the_guard(semi_implicit, damping):
    """Drums that hold: tensions held over a step feed energy in; semi-implicitly not, below step * omega = 2."""
    robot = on_winches(samples.braced(), "elastic", damping=damping, winch=HELD)
    about = oscillator(robot, make_state([0, 0, 2]))
    limit = longest(lambda h: about.gauss_seidel(h, 6, semi_implicit), 1.0) * about.fastest
    if damping == 0.0:
        assert limit == pytest.approx(2.0, abs=0.25) if semi_implicit else limit < 0.1
    else:
        assert 0.1 < limit < 2.0


@pytest.mark.parametrize("scheme", ["semi_implicit", "runge_kutta"])
def test_the_guard_knows_where_engines_diverge(scheme):
    """Just below the limit a small push stays one, just above it grows."""
    robot = on_winches(samples.braced(), "elastic", damping=20.0, winch=replace(HELD, inertia=1e6))
    state = make_state([0, 0, 2])
    about = oscillator(robot, state)
    step = getattr(about, scheme)
    limit = longest(step, 1.0)
    assert stable(step(limit))
    far = []
    for h in (0.95 * limit, 1.3 * limit):
        options = {} if scheme == "runge_kutta" else {"scheme": "semi_implicit_euler"}
        backend = plant("reference", robot, step=h, **options)
        backend.reset(state)
        backend.command[:] = distribute(robot, state[None, :7], solver="analytic_centre").tension[0]
        backend.external[2] = 0.1
        backend.step(200)
        far.append(np.abs(backend.state[:3] - state[:3]).max())
    assert far[0] < 1e-4
    assert not far[1] < 1e-3
