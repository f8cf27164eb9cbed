"""Deliberately broken controllers, each with the checks that must catch it."""

from __future__ import annotations

import dataclasses

import numpy as np

from cdpr.model import rotations
from cdpr.plugins import Column
from cdpr_controllers import ComputedTorqueOptions
from cdpr_controllers.computed_torque import ComputedTorque


class Broken(ComputedTorque):
    """Computed torque with its default gains."""

    def __init__(self, robot, gravity, control_step, options):
        super().__init__(robot, gravity, control_step, ComputedTorqueOptions())


class Unwritten(Broken):
    """It adds to the output instead of writing it."""

    def control(self, time, state, desired, out):
        wrench = np.zeros(6)
        super().control(time, state, desired, wrench)
        out += wrench


class Scribbling(Broken):
    """It wraps the desired quaternion's sign in place."""

    def control(self, time, state, desired, out):
        desired[3:7] *= -1.0
        super().control(time, state, desired, out)


class WoundUp(Broken):
    """Its integral survives a reset."""

    integral = 0.0

    def control(self, time, state, desired, out):
        super().control(time, state, desired, out)
        self.integral = self.integral + 1e-3 * (desired[:3] - state[:3])
        out[:3] += self.integral


class MassAtTheOrigin(Broken):
    """It takes the centre of mass to be the origin."""

    def __init__(self, robot, gravity, control_step, options):
        platform = dataclasses.replace(robot.platform, center_of_mass=np.zeros(3))
        super().__init__(dataclasses.replace(robot, platform=platform), gravity, control_step, options)


class EarthOnly(Broken):
    """It knows one gravity."""

    def __init__(self, robot, gravity, control_step, options):
        super().__init__(robot, np.array([0, 0, -9.81]), control_step, options)


class WrongSign(Broken):
    """It turns away from the target."""

    def control(self, time, state, desired, out):
        desired = desired.copy()
        turn = rotations.multiply(desired[3:7], rotations.conjugate(state[3:7]))
        desired[3:7] = rotations.multiply(rotations.conjugate(turn), state[3:7])
        super().control(time, state, desired, out)


class PlatformAxes(Broken):
    """It gives the moment's error part in platform axes."""

    def control(self, time, state, desired, out):
        super().control(time, state, desired, out)
        out[3:] = rotations.matrix(state[3:7]).T @ out[3:]


class HidingNan(Broken):
    def control(self, time, state, desired, out):
        super().control(time, np.nan_to_num(state), np.nan_to_num(desired), out)


class Undamped(Broken):
    """It pushes with the velocity."""

    def control(self, time, state, desired, out):
        state = state.copy()
        state[7:] = 2 * desired[7:13] - state[7:]
        super().control(time, state, desired, out)


class Unlogged(Broken):
    """It writes its columns into arrays of its own."""

    columns = (Column("pull", 6, "N, N m", "Its request", "world"),)

    def log(self, columns):
        self.pull = columns["pull"].copy()

    def control(self, time, state, desired, out):
        super().control(time, state, desired, out)
        self.pull[:] = out


class Deaf(ComputedTorque):
    """It receives only one of two options."""

    Options = ComputedTorqueOptions
    changeable = ("kp", "kd")

    def change(self, options):
        super().change(options.model_copy(update={"kd": 20.0}))


class Forgetful(Broken):
    """A change clears what it remembers."""

    changeable = ("kp",)
    calls = 0.0

    def change(self, options):
        super().change(options or ComputedTorqueOptions())
        self.calls = 0.0

    def control(self, time, state, desired, out):
        super().control(time, state, desired, out)
        self.calls += 1.0
        out += self.calls


class Unladen(Broken):
    """It keeps the platform that it was made for."""

    def renew(self, robot):
        return True


# Broken controller -> what it declares, and the checks that must fail. It may fail others too.
class Hasty(Broken):
    """Its period is in seconds."""

    period = 0.01


class Assuming(Broken):
    """It divides by the range of each cable's limits, also of a broken cable."""

    def observe(self, inputs):
        self.inputs = inputs

    def control(self, time, state, desired, out):
        super().control(time, state, desired, out)
        low, high = self.inputs.limits
        with np.errstate(divide="ignore"):
            out *= np.isfinite(np.sum(1.0 / (high - low))) or np.inf


class Pulling(Broken):
    """Its inner loop adds a tension that grows, also beyond limits and resets."""

    more = 0.0

    def inner_loop(self, distributed, tension):
        def correct(time):
            self.more += 0.1
            tension[:] = distributed + self.more

        return correct


class Unlimited(Broken):
    """Its inner loop ignores the limits."""

    def inner_loop(self, distributed, tension):
        def correct(time):
            tension[:] = distributed + 1e6

        return correct


MUTANTS = {
    Unwritten: ({}, ["output_is_complete"]),
    Scribbling: ({}, ["inputs_stay_unchanged"]),
    WoundUp: ({}, ["reset_forgets", "snapshot_restores"]),
    MassAtTheOrigin: ({}, ["on_target_it_carries_the_weight"]),
    EarthOnly: ({}, ["on_target_it_carries_the_weight", "directions_are_equal"]),
    WrongSign: ({}, ["it_pulls_towards_the_target", "it_settles"]),
    PlatformAxes: ({}, ["directions_are_equal"]),
    HidingNan: ({}, ["nan_shows"]),
    Undamped: ({}, ["it_settles"]),
    Unlogged: ({}, ["columns_are_written"]),
    Unladen: ({}, ["platform_is_renewed"]),
    Deaf: ({}, ["options_change"]),
    Forgetful: ({}, ["options_change"]),
    Hasty: ({}, ["period_is_whole"]),
    Pulling: ({}, ["tensions_are_corrected"]),
    Unlimited: ({}, ["tensions_are_corrected"]),
    Assuming: ({}, ["inputs_may_change"]),
}
