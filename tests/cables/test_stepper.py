"""Kernel of steppers with an inertia against the equations in the docstring of their module."""

from __future__ import annotations

import numpy as np
from test_part_equations import CLOSE, HARDLY, POSES, STEP, M, Sample

from cdpr.cables.elastic import ELASTIC
from cdpr.cables.stepper import STEPPER, STEPPER_MOTOR
from cdpr.cables.tables import SPAN
from cdpr.native.bind import bind

LOW, HIGH = [100.0, 1.0, 1.0, 1.0, 1.0], [400.0, 64.0, 50.0, 100.0, 3.0]  # numbers of `stepper.STEPS`
OWN = {STEPPER: 1, STEPPER_MOTOR: 5}  # their place in the numbers of the winch


class Stepping(Sample):
    """Elastic cables on steppers with random states."""

    def __init__(self, seed, winch):
        super().__init__(seed, winch, ELASTIC)
        rng = np.random.default_rng(seed + 2000)
        self.steps = rng.uniform(LOW, HIGH, (M, 5))
        chains = self.given["chains"].copy()
        chains[:, 3 : 3 + OWN[winch]] = self.drum[:, : OWN[winch]]
        chains[:, 3 + OWN[winch] : 8 + OWN[winch]] = self.steps
        chains[:, SPAN : SPAN + 2] = self.elastic
        self.given["chains"] = chains
        self.unwound, self.speed = self.length * rng.uniform(0.98, 1.005, M), rng.normal(size=M)
        self.reference = self.unwound + rng.uniform(-0.02, 0.02, M)
        self.command[:] = rng.normal(size=M)  # m/s

    def tension(self, unwound, speed):
        (stiffness, damping), radius = self.elastic.T, self.drum[:, 0]
        stretch = self.length - unwound
        tension = stiffness * stretch / unwound + damping * (self.rate + radius * speed)
        return np.where(stretch > 0.0, np.maximum(tension, 0.0), 0.0)

    def motor(self, unwound, reference):
        """Return M_s sin(pi/2 (l0 - L_c) / (r a)), N m."""
        step = self.drum[:, 0] * 2.0 * np.pi / (self.steps[:, 0] * self.steps[:, 4])  # m of a full step
        return self.steps[:, 2] * np.sin(0.5 * np.pi * (unwound - reference) / step)


def test_a_rotor_moves_under_its_torque():
    for seed in range(POSES):
        sample = Stepping(seed, STEPPER_MOTOR)
        radius, inertia = sample.drum.T[:2]
        sample.winch[:] = np.column_stack([sample.unwound, sample.speed, sample.reference]).ravel()
        bind("step_winches", **sample.given, step=STEP)()
        tension = sample.tension(sample.unwound, sample.speed)
        reference = sample.reference + STEP * sample.command  # own states are first in the semi-implicit scheme
        torque = sample.motor(sample.unwound, reference) - sample.friction(sample.speed) - radius * tension
        speed = sample.speed + STEP * torque / inertia
        expected = [sample.unwound - STEP * radius * speed, speed, reference]
        np.testing.assert_allclose(sample.light, tension, rtol=CLOSE, atol=HARDLY)
        np.testing.assert_allclose(sample.winch.reshape(M, -1).T, expected, rtol=CLOSE, atol=HARDLY)


def test_a_rotor_starts_where_it_holds_the_load():
    holds = 0
    for seed in range(POSES):
        sample = Stepping(seed, STEPPER_MOTOR)
        sample.command[:] = sample.length * 0.9999  # the first command is the unwound length
        bind("settle_winches", **sample.given)()
        unwound, speed, reference = sample.winch.reshape(M, 3).T
        assert unwound.tobytes() == sample.command.tobytes()
        load = sample.drum[:, 0] * sample.elastic[:, 0] * (sample.length - unwound) / unwound + sample.friction(speed)
        held = np.clip(load, -sample.steps[:, 2], sample.steps[:, 2])
        np.testing.assert_allclose(sample.motor(unwound, reference), held, rtol=1e-9, atol=1e-8)
        holds += (held == load).sum()
    assert 0 < holds < POSES * M


def test_a_stepper_without_inertia_turns_at_the_rate_of_its_steps():
    for seed in range(POSES):
        sample = Stepping(seed, STEPPER)
        sample.winch[:] = np.column_stack([sample.unwound, sample.speed]).ravel()
        bind("step_winches", **sample.given, step=STEP)()
        speed = -sample.command / sample.drum[:, 0]
        found = sample.winch.reshape(M, 2).T
        np.testing.assert_allclose(found, [sample.unwound + STEP * sample.command, speed], rtol=CLOSE, atol=HARDLY)
        np.testing.assert_allclose(sample.light, sample.tension(sample.unwound, speed), rtol=CLOSE, atol=HARDLY)
