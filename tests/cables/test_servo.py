"""Kernels of ideal drives and servos against the equations in the docstring of their module."""

from __future__ import annotations

import numpy as np
import pytest
from test_part_equations import CLOSE, HARDLY, POSES, STEP, M, Sample

from cdpr.cables.elastic import ELASTIC
from cdpr.cables.ideal_drive import IDEAL_DRIVE
from cdpr.cables.servo import POSITION_SERVO, VELOCITY_SERVO
from cdpr.cables.tables import SPAN
from cdpr.native.bind import bind

LOW = [0.1, 0.0, 1.0, 1.0, 0.5, 0.0, 5.0]  # `servo.LOOPS` and gain: such limits act in some of the samples
HIGH = [2.0, 50.0, 100.0, 500.0, 30.0, 0.01, 50.0]


class Drive(Sample):
    """Cables on drives, whose commands are lengths or rates, with random states."""

    def __init__(self, seed, winch):
        super().__init__(seed, winch, ELASTIC)
        rng = np.random.default_rng(seed + 1000)
        self.loops = rng.uniform(LOW, HIGH, (M, len(LOW)))
        self.loops[::2, -2] = 0.0  # without a lag
        chains = self.given["chains"].copy()
        chains[:, 3 : 3 + 5] = self.drum
        if winch in (POSITION_SERVO, VELOCITY_SERVO):
            chains[:, 8 : 8 + len(LOW)] = self.loops
        chains[:, SPAN : SPAN + 2] = self.elastic
        self.given["chains"] = chains
        self.unwound, self.speed = self.length * rng.uniform(0.98, 1.005, M), rng.normal(size=M)
        self.integral, self.torque = rng.uniform(-5.0, 20.0, (2, M))
        by_length = winch is POSITION_SERVO
        self.command[:] = self.length * rng.uniform(0.97, 1.01, M) if by_length else rng.normal(size=M)

    def tension(self, unwound, speed):
        """Return the tensions of the elastic cables, N."""
        (stiffness, damping), radius = self.elastic.T, self.drum[:, 0]
        stretch = self.length - unwound
        tension = stiffness * stretch / unwound + damping * (self.rate + radius * speed)
        return np.where(stretch > 0.0, np.maximum(tension, 0.0), 0.0)


def check(sample, tension, states):
    np.testing.assert_allclose(sample.light, tension, rtol=CLOSE, atol=HARDLY)
    found = sample.winch.reshape(M, -1).T
    np.testing.assert_allclose(found, states, rtol=CLOSE, atol=HARDLY)


def test_an_ideal_drive_winds_at_its_command():
    for seed in range(POSES):
        sample = Drive(seed, IDEAL_DRIVE)
        sample.winch[:] = np.column_stack([sample.unwound, sample.speed]).ravel()
        bind("step_winches", **sample.given, step=STEP)()
        speed = -sample.command / sample.drum[:, 0]
        check(sample, sample.tension(sample.unwound, speed), [sample.unwound + STEP * sample.command, speed])


@pytest.mark.parametrize("winch", [POSITION_SERVO, VELOCITY_SERVO])
def test_servos(winch):
    """Cascaded loops: w_d, tau_d, z', tau' and w' in one step of the semi-implicit scheme."""
    acted = np.zeros(3, dtype=int)
    for seed in range(POSES):
        sample = Drive(seed, winch)
        z, tau, w = sample.integral, sample.torque, sample.speed
        sample.winch[:] = np.column_stack([sample.unwound, w, z, tau]).ravel()
        bind("step_winches", **sample.given, step=STEP)()
        r, inertia = sample.drum.T[:2]
        kv, ki, w_max, a_max, tau_max, lag, kp = sample.loops.T
        wanted = kp * (sample.unwound - sample.command) / r if winch is POSITION_SERVO else -sample.command / r
        error = np.clip(wanted, -w_max, w_max) - w
        free = np.clip(kv * error, -inertia * a_max, inertia * a_max) + z
        demand = np.clip(free, -tau_max, tau_max)
        acted += [(abs(wanted) > w_max).sum(), (abs(kv * error) > inertia * a_max).sum(), (demand != free).sum()]
        tension = sample.tension(sample.unwound, w)
        z_next = z + STEP * np.where((demand != free) & (demand * error > 0.0), 0.0, ki * error)
        tau_next = np.where(lag > 0.0, tau + STEP * (demand - tau) / np.where(lag > 0.0, lag, 1.0), tau)
        # semi-implicit: the own states first, and the speed with them
        free = np.clip(kv * error, -inertia * a_max, inertia * a_max) + z_next
        motor = np.where(lag > 0.0, tau_next, np.clip(free, -tau_max, tau_max))
        w_next = w + STEP * (motor - sample.friction(w) - r * tension) / inertia
        check(sample, tension, [sample.unwound - STEP * r * w_next, w_next, z_next, tau_next])
    assert (acted > 10).all()  # each of the limits


def test_a_servo_starts_at_its_command_and_holds_the_load():
    for seed in range(POSES):
        sample = Drive(seed, POSITION_SERVO)
        bind("settle_winches", **sample.given)()
        unwound, speed, integral, torque = sample.winch.reshape(M, 4).T
        assert unwound.tobytes() == sample.command.tobytes()
        np.testing.assert_allclose(speed, -sample.rate / sample.drum[:, 0], rtol=CLOSE)
        load = sample.drum[:, 0] * sample.tension(unwound, speed) + sample.friction(speed)
        np.testing.assert_allclose(integral, load, rtol=CLOSE, atol=HARDLY)
        assert torque.tobytes() == integral.tobytes()
