"""Kernels of winches, exits and spans against the equations in the docstrings of their packages, on random inputs."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot, random_state

from cdpr.cables import EXITS, Pulley
from cdpr.cables.catenary import CATENARY
from cdpr.cables.chain import Chain
from cdpr.cables.direct import DIRECT
from cdpr.cables.drum import DRUM
from cdpr.cables.elastic import ELASTIC
from cdpr.cables.ideal_drive import IDEAL_DRIVE
from cdpr.cables.inextensible import INEXTENSIBLE
from cdpr.cables.servo import POSITION_SERVO, VELOCITY_SERVO
from cdpr.cables.stepper import STEPPERS
from cdpr.cables.tables import CHAIN_WIDTH, SPAN, SPANS, TRANSMISSION, WINCHES, exits
from cdpr.cables.tabulated import TABULATED
from cdpr.cables.viscoelastic import VISCOELASTIC
from cdpr.mechanics.body_frame import BodyFrame, body_state
from cdpr.mechanics.winches import Winches
from cdpr.model import rotations
from cdpr.native.bind import bind

POSES, M = 25, 8  # 200 cables
STEP = 1e-3  # s
CLOSE = 1e-11  # relative: some roundings, and differences of lengths
HARDLY = 1e-9  # N or 1/s^2: round-off of sums of much larger terms
# Numbers of drums, elastic spans and transmissions: efficiency, speed of the losses, growth, lines, falls, home length.
LOW = {"drum": [0.02, 1e-3, 0.0, 0.0, 0.05], "elastic": [1e4, 0.0], "line": [0.5, 0.05, 0.0, 1.0, 1.0, 4.0]}
HIGH = {"drum": [0.10, 0.1, 0.05, 2.0, 2.0], "elastic": [1e6, 100.0], "line": [1.0, 2.0, 1e-5, 3.0, 4.0, 8.0]}
IDEAL = [1.0, 0.1, 0.0, 1.0, 1.0, np.nan]


class Sample:
    """Plant of random cables at a random state, with its kinematics by numpy."""

    def __init__(self, seed, winch, span, lowest=0.0, geared=False):
        rng = np.random.default_rng(seed)
        robot, self.state = make_robot(crossed_box(rng, M)), random_state(rng)
        names = "drum", "elastic"
        self.drum, self.elastic = (rng.uniform(LOW[name], HIGH[name], (M, len(LOW[name]))) for name in names)
        self.command = rng.uniform(1.0, 500.0, M)
        chains = np.zeros((M, CHAIN_WIDTH))
        chains[:, :3] = WINCHES.index(winch), SPANS.index(span), lowest
        if winch is DRUM:
            chains[:, 3 : 3 + self.drum.shape[1]] = self.drum
        if span is ELASTIC:
            chains[:, SPAN : SPAN + self.elastic.shape[1]] = self.elastic
        self.line = rng.uniform(LOW["line"], HIGH["line"], (M, 6)) if geared else np.tile(IDEAL, (M, 1))
        chains[:, TRANSMISSION:SPAN] = self.line
        frame = BodyFrame(robot)
        arrays = self.command, np.zeros(6), body_state(frame.offset, self.state), np.zeros(6)
        given = Winches(robot, frame, np.zeros(3), *arrays, STEP).given
        kinds = np.column_stack([chains[:, :2].astype(np.int64), np.zeros(M, dtype=np.int64)])
        places = Chain(winch, span).states * np.arange(M + 1)
        self.light, self.mass, self.winch = np.full(M, np.nan), np.full(M, np.nan), np.full(places[-1], np.nan)
        given |= {"chains": chains, "kinds": kinds, "light": self.light, "mass": self.mass}
        self.given = {**given, "winch": self.winch, "places": places}
        lever = robot.anchors[:, 3:] @ rotations.matrix(self.state[3:7]).T
        velocity = self.state[7:10] + np.cross(self.state[10:], lever)
        chord = self.state[:3] + lever - robot.anchors[:, :3]
        self.length = np.linalg.norm(chord, axis=1)
        along = chord / self.length[:, None]
        self.rate = np.sum(along * velocity, axis=1)
        turning = np.cross(self.state[10:], np.cross(self.state[10:], lever))  # acceleration of the tip by itself
        self.length_acceleration = np.sum(along * turning, axis=1)
        self.length_acceleration += (np.sum(velocity**2, axis=1) - self.rate**2) / self.length

    def friction(self, speed):
        """Return f(w) = b w + c tanh(w / w_c), N m."""
        _, _, viscous, coulomb, coulomb_speed = self.drum.T
        return viscous * speed + coulomb * np.tanh(speed / coulomb_speed)

    def per_turn(self, unwound):
        """Return r / k with r^2 = r_0^2 + g n k (L - U), m."""
        _, _, growth, lines, reeving, home = self.line.T
        wound = np.where(growth > 0.0, reeving * (home - unwound), 0.0)
        return np.sqrt(self.drum[:, 0] ** 2 + growth * lines * wound) / reeving

    def load(self, speed):
        """Return (1 + e + s) / (1 + e - s), s = (1 - e) tanh(w / w_c)."""
        efficiency, coulomb_speed = self.line[:, :2].T
        lost = (1.0 - efficiency) * np.tanh(speed / coulomb_speed)
        return (1.0 + efficiency + lost) / (1.0 + efficiency - lost)


@pytest.mark.parametrize("geared", [False, True])
def test_a_drum_with_a_cable_that_does_not_stretch(geared):
    """T = (u - f(w) / r - I w' / r) / load with w = -l' / r and, for r(l), w' = -l'' / r + r'(l) l'^2 / r^2."""
    for seed in range(POSES):
        sample = Sample(seed, DRUM, INEXTENSIBLE, geared=geared)
        bind("settle_winches", **sample.given)()
        radius, inertia, nearby = sample.per_turn(sample.length), sample.drum[:, 1], 1e-4
        slope = (sample.per_turn(sample.length + nearby) - sample.per_turn(sample.length - nearby)) / (2.0 * nearby)
        speed = -sample.rate / radius
        turning = -sample.length_acceleration / radius + slope * (sample.rate / radius) ** 2
        load = sample.load(speed)
        mass = inertia / radius**2 / load
        tension = (sample.command - (sample.friction(speed) + inertia * turning) / radius) / load
        np.testing.assert_allclose(sample.mass, mass, rtol=CLOSE)
        np.testing.assert_allclose(sample.light, tension, rtol=CLOSE, atol=HARDLY)


def test_a_motor_that_holds_the_commanded_tension():
    """T = u."""
    for seed in range(POSES):
        sample = Sample(seed, DIRECT, INEXTENSIBLE)
        bind("settle_winches", **sample.given)()
        assert sample.light.tobytes() == sample.command.tobytes()
        assert not sample.mass.any()


@pytest.mark.parametrize(("lowest", "geared"), [(0.0, False), (0.0, True), (-np.inf, False)])
def test_a_drum_with_an_elastic_cable(lowest, geared):
    """T = E A (l - l0) / l0 + d (l' - l0'), l0' = -r w, and I w' = r u - f(w) - r T load; stretched or slack."""
    for seed in range(POSES):
        sample = Sample(seed, DRUM, ELASTIC, lowest, geared)
        rng, (stiffness, damping), inertia = np.random.default_rng(seed), sample.elastic.T, sample.drum[:, 1]
        unwound, speed = sample.length * rng.uniform(0.98, 1.005, M), rng.normal(size=M)
        sample.winch[:] = np.column_stack([unwound, speed]).ravel()
        radius, load = sample.per_turn(unwound), sample.load(speed)
        bind("step_winches", **sample.given, step=STEP)()
        stretch = sample.length - unwound
        tension = stiffness * stretch / unwound + damping * (sample.rate + radius * speed)
        if lowest == 0.0:
            tension = np.where(stretch > 0.0, np.maximum(tension, 0.0), 0.0)
            assert (tension == 0.0).any()
        np.testing.assert_allclose(sample.light, tension, rtol=CLOSE, atol=HARDLY)
        speed = speed + STEP * (radius * sample.command - sample.friction(speed) - radius * tension * load) / inertia
        found = sample.winch.reshape(M, 2).T
        np.testing.assert_allclose(found, [unwound - STEP * radius * speed, speed], rtol=CLOSE, atol=HARDLY)


def test_an_elastic_cable_starts_at_its_command_with_constant_stretch():
    for seed in range(POSES):
        sample = Sample(seed, DRUM, ELASTIC)
        bind("settle_winches", **sample.given)()
        unwound, speed = sample.winch.reshape(M, 2).T
        np.testing.assert_allclose(unwound, sample.length / (1.0 + sample.command / sample.elastic[:, 0]), rtol=CLOSE)
        np.testing.assert_allclose(speed, -sample.rate / sample.drum[:, 0], rtol=CLOSE)


def test_a_swivelling_pulley():
    """E = A + r (1 - cos beta) e_x + r sin beta a, and r beta of cable on the groove."""
    rng, count, checked = np.random.default_rng(5), POSES * M, 0
    anchors, tips = rng.uniform(-3.0, 3.0, (2, count, 3))
    radii, axes = rng.random(count), rng.normal(size=(count, 3))
    pulleys = [Pulley(radius=r, axis=tuple(axis)) for r, axis in zip(radii, axes, strict=True)]
    kind = list(EXITS).index("pulley")
    lines = np.array([[*A, 0.0, 0.0, 0.0, kind, *each.numbers()] for A, each in zip(anchors, pulleys, strict=True)])
    points, _, wrapped_length = exits(lines, tips)
    for A, P, pulley, E, wrapped in zip(anchors, tips, pulleys, points, wrapped_length, strict=True):
        r, a = pulley.radius, np.array(pulley.axis) / np.linalg.norm(pulley.axis)
        if pulley.obstacle(A, P):
            assert np.isnan(wrapped)
            continue
        z = (P - A) @ a
        away = P - A - z * a
        c = np.linalg.norm(away) - r
        f = np.sqrt(c**2 + z**2 - r**2)
        sine, cosine = np.array([f * c + r * z, f * z - r * c]) / (c**2 + z**2)
        beta = np.arctan2(sine, cosine)
        beta += 2.0 * np.pi * (beta < -0.5 * np.pi)
        expected = A + r * (1.0 - cosine) * away / np.linalg.norm(away) + r * sine * a
        np.testing.assert_allclose(E, expected, atol=CLOSE)
        np.testing.assert_allclose(wrapped, r * beta, atol=CLOSE)
        checked += 1
    assert checked > 0.8 * count


def test_every_part_is_compared():
    drives = {IDEAL_DRIVE, POSITION_SERVO, VELOCITY_SERVO}  # test_servo.py
    assert {DIRECT, DRUM, *drives, *STEPPERS} == set(WINCHES)  # the last two in test_stepper.py
    others = {CATENARY, TABULATED, VISCOELASTIC}  # test_catenary.py, test_tabulated.py and test_viscoelastic.py
    assert {INEXTENSIBLE, ELASTIC, *others} == set(SPANS)
    assert [Pulley] == [kind for kind in EXITS.values() if kind.header]
