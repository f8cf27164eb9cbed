"""Elementary functions of the friction of pulleys, and results that are not computed twice."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from plants import installed
from scipy.spatial.transform import Rotation

from cdpr.cables import Pulley
from cdpr.native.bind import bind
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build

RADIUS, SPEED, M = 0.1, 0.02, 8
TOGETHER = 50  # cables at one speed
SCENARIO = ROOT / "scenarios" / "cogiro_pulleys.yaml"
ROUNDING = 1e-15  # of wrap angle, tanh and each exponential: a few units in the last place
EXACT = np.longdouble  # 64 bits of mantissa


def lines_of(anchors, **friction):
    """Rows of cables whose pulleys have the axis z and lead to the body's origin."""
    numbers = Pulley(radius=RADIUS, axis=(0.0, 0.0, 1.0), friction_speed=SPEED, **friction).numbers()
    return np.array([[*anchor, 0.0, 0.0, 0.0, 1.0, *numbers] for anchor in anchors])


def pulled(lines, body):
    """Tensions at the platform for 1 N at the winches."""
    m = len(lines)
    tension, last = np.zeros(m), np.zeros(2 * m + 20)
    bind("exit_tensions", lines=lines, body=body, command=np.ones(m), tension=tension, last=last)()
    return tension


def wound(wrap, free):
    """Anchors of pulleys on which a cable to the origin lies over these angles, of at most these free lengths (k,)."""
    with np.errstate(divide="ignore"):
        axis = RADIUS * (1.0 - np.cos(wrap)) / -np.sin(wrap)  # free length up to the axis
    free = np.where(wrap > np.pi, np.minimum(free, 0.9 * axis), free)
    x = RADIUS * (1.0 - np.cos(wrap)) + free * np.sin(wrap)
    z = RADIUS * np.sin(wrap) + free * np.cos(wrap)
    return -np.stack([x, 0.0 * x, z], axis=1)


def test_friction_at_all_angles_and_speeds():
    """exp(mu beta tanh(speed / v0)) with 64 bits of mantissa, from the smallest angle to three quarters of a turn."""
    rng = np.random.default_rng(0)
    wrap = np.concatenate([np.geomspace(1e-6, 0.1, 2000), np.linspace(0.1, 1.49 * np.pi, 8000)])
    speed = rng.choice([-1.0, 1.0], len(wrap)) * np.geomspace(1e-9, 10.0, len(wrap))[rng.permutation(len(wrap))]
    anchors = wound(wrap, rng.uniform(3.0, 6.0, len(wrap)))
    x, z, r = -anchors[:, 0].astype(EXACT), -anchors[:, 2].astype(EXACT), EXACT(RADIUS)
    free, c = np.sqrt(x * (x - 2 * r) + z * z), x - r
    sine, cosine = (free * c + r * z) / (c * c + z * z), (free * z - r * c) / (c * c + z * z)
    angle = np.arctan2(sine, cosine)
    angle = np.where(angle < -EXACT(0.1), angle + 2 * EXACT(np.pi), angle)
    np.testing.assert_allclose(angle.astype(float), wrap, rtol=0, atol=1e-13)
    for coefficient in (0.05, 2.0, 10.0):
        for k in range(0, len(wrap), TOGETHER):
            rows = slice(k, k + TOGETHER)
            # along z, the pull of a cable has the cosine of the angle
            body = np.array([0, 0, 0, 1, 0, 0, 0, 0, 0, speed[k], 0, 0, 0.0])
            found = pulled(lines_of(anchors[rows], friction=coefficient), body)
            rate = EXACT(speed[k]) * cosine[rows]
            exponent = EXACT(coefficient) * np.tanh(rate / EXACT(SPEED)) * angle[rows]
            error = np.abs(found / np.exp(exponent) - 1.0)
            assert (error <= ROUNDING * (1.0 + 4.0 * coefficient * (angle[rows] + 1.0))).all()


@pytest.mark.parametrize("friction", [{"friction": 0.2}, {"bearing_friction": 0.3, "bearing_radius": 0.03}])
def test_eight_cables_have_the_bits_of_each_alone(friction):
    rng = np.random.default_rng(1)
    finite = 0
    for _ in range(200):
        anchors = wound(rng.uniform(0.0, 1.49 * np.pi, M), rng.uniform(1.0, 6.0, M))
        lines = lines_of(anchors @ Rotation.from_rotvec([0.0, 0.0, rng.uniform(-3.0, 3.0)]).as_matrix(), **friction)
        body = np.concatenate([0.01 * rng.normal(size=3), [1.0, 0.0, 0.0, 0.0], 0.02 * rng.normal(size=6)])
        alone = [pulled(lines[[i]], body)[0] for i in range(M)]
        finite += np.isfinite(alone).sum()
        np.testing.assert_array_equal(pulled(lines, body), alone)
    assert finite > 0.9 * 200 * M  # others lie within their pulley


def scenario_of(backend, model, **platform):
    """The scenario with friction on its pulleys."""
    keys = {"robot.cable.exit.friction": 0.2, "robot.cable.exit.friction_speed": 0.1}
    keys |= {f"robot.platform.{key}": value for key, value in platform.items()}
    if model != "ideal":
        keys |= {"robot.cable.model": model, "robot.winch": {"drum_radius": 0.05, "inertia": 0.02}}
    if model == "elastic":
        keys |= {"robot.cable.axial_stiffness": 1e6, "robot.cable.damping": 500.0}
    return load_scenario(SCENARIO, backend=backend, overrides={**keys, "initial.velocity": [0.3, -0.2, 0.1]})


def moved(backend, model, read):
    """States, largest tensions and work of steps between which tensions may be read and the platform changes."""
    scenario = scenario_of(backend, model)
    other = scenario_of(backend, model, mass=120.0, center_of_mass=[0.0, 0.0, 0.1]).robot
    plant = build(scenario).backend
    plant.reset(scenario.initial.state())
    tension, found = np.zeros(M), []
    for k in range(30):
        plant.command[:] = 300.0 + 50.0 * np.sin(k + np.arange(M))
        if read:
            plant.read_tension(tension)
            plant.read_tension(tension)
        if k == 10:
            plant.load(other)
        if k == 20:
            plant.reset(scenario.initial.state())
        plant.step(1 + k % 2)
        found.append(np.concatenate([plant.state, plant.highest, [plant.cable_work()]]))
    return np.array(found)


@pytest.mark.parametrize("backend", ["reference", *installed("mujoco")])
@pytest.mark.parametrize("model", ["ideal", "rigid", "elastic"])
def test_reading_the_tensions_changes_no_bit(backend, model):
    """A step takes from the last reading what it would compute."""
    plain, read = moved(backend, model, read=False), moved(backend, model, read=True)
    assert np.isfinite(plain).all()
    np.testing.assert_array_equal(plain[:, :13], read[:, :13])
    if model == "ideal":  # otherwise a reading is a sample of the largest tension
        np.testing.assert_array_equal(plain, read)


@pytest.mark.parametrize("backend", ["reference", *installed("mujoco")])
@pytest.mark.parametrize("model", ["ideal", "rigid", "elastic"])
def test_another_platform_at_the_same_place_of_its_centre_of_mass(backend, model):
    """Its anchors have other places relative to the centre of mass: nothing is taken from the last reading."""
    along_axes = [36.0, 35.0, 25.0, 0.0, 0.0, 0.0]  # so that no rounding moves the centre of mass
    changes = [{"center_of_mass": [0.0, 0.0, z], "inertia": along_axes} for z in (0.0, 0.25)]
    one, other = (scenario_of(backend, model, **each) for each in changes)
    state = np.array([0.0, 0.0, 2.5, 1.0, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0])
    lower, found = state - 0.25 * np.eye(13)[2], []
    changed, fresh = build(one).backend, build(other).backend
    for plant in changed, fresh:
        plant.reset(state if plant is changed else lower)
        plant.command[:] = 300.0
        plant.read_tension(np.zeros(M))
    changed.load(other.robot)
    for plant in changed, fresh:
        plant.reset(lower)
        plant.step(3)
        found.append(np.concatenate([plant.state, plant.highest, [plant.cable_work()]]))
    np.testing.assert_array_equal(*found)
