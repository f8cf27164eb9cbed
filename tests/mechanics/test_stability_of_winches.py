"""The linearised robot uses only numbers that its winches declare."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import CdprError, Diverged
from cdpr.base.fields import Positive
from cdpr.cables import MODELS
from cdpr.cables.chain import Chain, Number, Winch
from cdpr.mechanics import stability
from cdpr.plugins.registry import registry
from cdpr.simulation.build import check_cables, faults
from cdpr.simulation.loop_problems import loop_problems

WINCH = ROOT / "scenarios" / "winch.yaml"
LONG = {"simulation.physics_step": 0.5, "simulation.control_step": 0.5, "robot.cable.model": "elastic"}


def use(monkeypatch, *numbers):
    """Let all cables have a winch with these numbers on a span that stretches."""
    chain = Chain(Winch(header="own.hpp", numbers=numbers, states=2), MODELS["elastic"].span)
    monkeypatch.setattr(stability, "chain_of", lambda robot, cable: chain)


def drum_numbers(*keys):
    return [number for number in MODELS["elastic"].winch.numbers if number.key in keys]


def test_friction_that_a_winch_does_not_declare_is_not_used(monkeypatch):
    scenario = cdpr.load_scenario(WINCH, overrides={"robot.cable.model": "elastic"})
    still = {"viscous_friction": 0.0, "coulomb_friction": 0.0}
    cables = tuple(replace(cable, winch=replace(cable.winch, **still)) for cable in scenario.robot.cables)
    state = scenario.initial.state()
    expected = stability.oscillator(replace(scenario.robot, cables=cables), state).C
    assert not np.array_equal(stability.oscillator(scenario.robot, state).C, expected)
    use(monkeypatch, *drum_numbers("drum_radius", "inertia"))
    assert np.array_equal(stability.oscillator(scenario.robot, state).C, expected)


def test_the_step_of_winches_without_a_drum_is_not_checked(monkeypatch):
    """Their numbers are not those of a drum: the stable step is unknown."""
    scenario = cdpr.load_scenario(WINCH, overrides=LONG)
    backend = registry().get("backend", "reference")
    with pytest.raises(CdprError, match=r"simulation\.physics_step 0\.5 s is too long"):
        check_cables(scenario, backend)
    use(monkeypatch, Number("winch.pitch", Positive, "m", "pitch of the screw"), *drum_numbers("inertia"))
    check_cables(scenario, backend)


def on_servos(**winch):
    """Return a platform on four lines with servos, at rest, with the reference's semi-implicit scheme."""
    anchors = [[-2.0, -2.0, 3.0], [2.0, -2.0, 3.0], [2.0, 2.0, 3.0], [-2.0, 2.0, 3.0]]
    data = {
        "robot": {
            "name": "camera",
            "dof": ["x", "y", "z"],
            "platform": {"mass": 10.0},
            "tension": {"min": 0, "max": 4000},
            "home": {"position": [0.0, 0.0, 1.0]},
            "cable": {"model": "elastic", "axial_stiffness": 2e4, "damping": 100.0},
            "winch": winch,
            "cables": [{"frame": A, "platform": [0, 0, 0]} for A in anchors],
        },
        "simulation": {"backend": "reference", "duration": 0.5, "control_step": 0.0005, "physics_step": 0.0005},
        "backend_options": {"reference": {"scheme": "semi_implicit_euler"}},
        "trajectory": {"type": "hold"},
        "controller": {"type": "inverse_kinematics", "flex_compensation": True},
    }
    if winch["type"] == "torque":
        data["controller"] = {"type": "computed_torque"}
    return cdpr.load_scenario(data)


DRUM = {"drum_radius": 0.05, "inertia": 0.002}
SERVOS = {
    "velocity loop": {"type": "position", **DRUM, "velocity_gain": 10.0},
    "position loop": {"type": "position", **DRUM, "velocity_gain": 1.0, "position_gain": 5000.0},
    "integral": {"type": "position", **DRUM, "velocity_gain": 0.5, "integral_gain": 20000.0},
    "velocity": {"type": "velocity", **DRUM, "velocity_gain": 10.0},
    "ideal": {"type": "position"},
}
STEPPER = {"type": "stepper", "drum_radius": 0.05, "stall_torque": 20.0, "steps_per_turn": 100.0}


def test_a_stepper_adds_the_slope_of_its_torque():
    """With an inertia; without, its lengths do not depend on the motion."""
    ideal, fixed, rotor = (
        stability.oscillator(scenario.robot, scenario.initial.state()).K
        for scenario in (on_servos(**each) for each in (SERVOS["ideal"], STEPPER, STEPPER | {"inertia": 0.002}))
    )
    assert np.array_equal(fixed, ideal)
    free = on_servos(type="torque", **DRUM)
    free = stability.oscillator(free.robot, free.initial.state()).K
    full_step = 2.0 * np.pi / 100.0  # rad
    expected = np.diag([0.0] * 3 + [0.5 * np.pi * 20.0 / (full_step * 0.05**2)] * 4)
    np.testing.assert_allclose(rotor - free, expected, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("name", SERVOS)
def test_servos_are_bounded_up_to_the_longest_stable_step(name, monkeypatch):
    scenario = on_servos(**SERVOS[name])
    robot, state = scenario.robot, scenario.initial.state()
    assert stability.supports_oscillator(robot)
    step = stability.longest(stability.oscillator(robot, state).semi_implicit, 0.1)

    def speed(h):
        steps = {"simulation.physics_step": h, "simulation.control_step": h, "simulation.duration": 400 * h}
        run = cdpr.simulate(scenario, overrides={"initial.velocity": [0.0, 0.0, 1e-3], **steps})
        return np.abs(run["unstretched_rate"][-20:]).max() + np.abs(run.velocity[-20:]).max()

    assert speed(0.9 * step) < 0.1
    if name != "ideal":  # its lengths do not move, and the check of the platform is that of elastic cables
        with pytest.raises(CdprError, match="is too long for these cables and winches"):
            speed(1.3 * step)
    monkeypatch.setattr("cdpr.simulation.build.check_cables", lambda scenario, backend, state=None: None)
    try:
        fast = speed(1.3 * step)
    except Diverged:
        fast = np.inf
    assert fast > 1.0


def test_lags_shorter_than_half_a_step_are_rejected():
    winch = SERVOS["velocity loop"] | {"torque_lag": 2e-4}
    with pytest.raises(
        CdprError, match=r"the winch of cable 'cable_1' with the torque_lag 0\.0002 s: expected at most"
    ):
        cdpr.simulate(on_servos(**winch))
    assert cdpr.simulate(on_servos(**winch | {"torque_lag": 1e-3})).status == "finished"


def test_losses_are_estimated_with_the_tensions_that_carry_the_weight():
    """Also without a lower limit: with 1 ms the torque of the losses alternates between its two signs."""
    lossy = {
        "robot.winch.coulomb_friction": 0.0,
        "robot.winch.efficiency": 0.5,
        "robot.tension": {"min": 0, "max": 1e4},
    }
    with pytest.raises(CdprError, match=r"simulation\.physics_step 0\.001 s is too long for these cables and winches"):
        check_cables(cdpr.load_scenario(WINCH, overrides=lossy), registry().get("backend", "reference"))
    weightless = cdpr.load_scenario(WINCH, overrides=lossy | {"world.gravity": [0.0, 0.0, 0.0]})
    check_cables(weightless, registry().get("backend", "reference"))


PULLEYS = ROOT / "scenarios" / "cogiro_pulleys.yaml"
NEVER = r"no simulation\.physics_step above 1e-9 s is stable for these cables and winches"


@pytest.mark.parametrize(
    ("file", "changes"),
    [
        (WINCH, {"robot.winch.inertia": 1e-300}),
        (WINCH, {"robot.winch.inertia": 5e-324}),
        (WINCH, {"robot.winch.coulomb_speed": 1e-300}),
        (WINCH, {"robot.winch.drum_radius": 1e-300}),
        (PULLEYS, {"robot.cable.exit.friction": 0.1, "robot.cable.exit.friction_speed": 1e-300}),
    ],
    ids=["inertia", "no inertia", "coulomb_speed", "drum_radius", "friction_speed"],
)
@pytest.mark.filterwarnings("error")
def test_numbers_out_of_range_are_one_error(file, changes):
    found = list(faults(cdpr.load_scenario(file, overrides=changes)))
    assert [fault.path for fault in found] == [("simulation", "physics_step")]
    assert re.match(NEVER, str(found[0].error))


@pytest.mark.filterwarnings("error")
def test_an_empty_drum_is_named():
    scenario = cdpr.load_scenario(WINCH, overrides={"robot.winch.drum_growth": 0.005})
    text = r"cable 'cable_1': its drum is empty at a length of 5\.76 m"
    assert not list(faults(scenario))  # the drum is empty at the end of the motion
    assert re.match(f"not computed: {text}", loop_problems(scenario)[0])
    end = scenario.desired.sample(2.0)[:3]
    found = list(faults(scenario.with_changes({"initial.position": end.tolist(), "trajectory": {"type": "hold"}})))
    assert [fault.path for fault in found] == [("robot", "winch")]
    assert re.match(r"cable 'cable_1': its drum is empty at a length of", str(found[0].error))


def test_a_step_that_is_too_long_only_later_is_a_warning():
    lossy = {"robot.winch.efficiency": 0.8, "robot.winch.coulomb_speed": 1.0}
    scenario = cdpr.load_scenario(WINCH, overrides=lossy)
    assert not list(faults(scenario))
    text = dict(loop_problems(scenario)[1])["simulation", "physics_step"]
    assert re.match(
        r"0\.001 s is too long for these cables and winches, .* may diverge: at 2 s of the motion they swing", text
    )
