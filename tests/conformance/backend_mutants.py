"""Deliberately broken backends, each with the checks that must catch it.

Each is the reference backend with one fault. The stepping traps of engines, which `cdpr compare` also detects,
are in tests/plugins/traps: wrong frame, damping, speed clamp, persistent wrench, lag, silent reset, dropped NaN.
"""

from __future__ import annotations

import os
from pathlib import Path

import anchor_mutants
import load_mutants
import numpy as np
import surroundings_mutants
import winch_mutants
from cdpr_traps.backend import (
    AutoReset,
    BodyFrameBothWays,
    BodyFrameRead,
    Clamp,
    Damping,
    DroppedNan,
    Lag,
    Persistent,
    Wrapped,
)

from cdpr.base.errors import PluginError
from cdpr.model import rotations
from cdpr.plugins import Column
from cdpr.plugins.backend import Phases


class Momentary(Wrapped):
    """The opposite: the wrench lasts one step instead of being held."""

    def step(self, n):
        super().step(min(n, 1))
        kept, self.external = self.external, np.zeros(6)
        super().step(n - min(n, 1))
        self.external = kept


class Unread(Wrapped):
    """Its phases do not publish the state after the step."""

    def phases(self):
        return Phases([], [lambda: self.inner.step(1)], [])


class Sleeping(Wrapped):
    """Slow bodies come to rest."""

    def after(self):
        if np.abs(self.inner.state[7:]).max() < 1e-3:
            self.put(np.concatenate([self.inner.state[:7], np.zeros(6)]))


class LightSleep(Wrapped):
    """Very slow bodies stop without a load."""

    fields = slice(7, 10)

    def after(self):
        state = self.inner.state.copy()
        still = not self.command.any() and not self.external.any()
        if still and 0.0 < np.abs(state[self.fields]).max() < 1e-6:
            state[self.fields] = 0.0
            self.put(state)


class LightSleepOfTurns(LightSleep):
    """Very slow rotations stop."""

    fields = slice(10, 13)


class GravityUnderLoad(Wrapped):
    """Gravity is off by a thousandth under more than 1500 N."""

    def __init__(self, robot, gravity, *rest):
        super().__init__(robot, gravity, *rest)
        self.weight = robot.platform.mass * np.asarray(gravity)

    def loads(self):
        external = self.external.copy()
        if self.command.sum() + np.linalg.norm(external[:3]) > 1500.0:
            external[:3] += 1e-3 * self.weight
            arm = rotations.matrix(self.inner.state[3:7]) @ self.robot.platform.center_of_mass
            external[3:] += np.cross(arm, 1e-3 * self.weight)
        return self.command, external


class MomentsUnderLoad(Wrapped):
    """Moments above 2000 N m are off by a thousandth."""

    def loads(self):
        external = self.external.copy()
        if np.linalg.norm(external[3:]) > 2000.0:
            external[3:] *= 1.001
        return self.command, external


class OwnGravity(Wrapped):
    """Gravity is the world's, whatever it was given."""

    def __init__(self, robot, gravity, physics_step, options):
        super().__init__(robot, np.array([0, 0, -9.81]), physics_step, options)


class WrenchInPlatformAxes(Wrapped):
    def loads(self):
        R = rotations.matrix(self.inner.state[3:7])
        return self.command, np.concatenate([R @ self.external[:3], R @ self.external[3:]])


class WrenchAtCentreOfMass(Wrapped):
    def loads(self):
        external = self.external.copy()
        arm = rotations.matrix(self.inner.state[3:7]) @ self.robot.platform.center_of_mass
        external[3:] += np.cross(arm, external[:3])
        return self.command, external


class ClampedAtTheLimits(Wrapped):
    """It takes the robot's tension limits for its own."""

    def loads(self):
        return np.clip(self.command, 0.0, self.robot.tension_max), self.external


class DeadBand(Wrapped):
    """Small loads have no effect."""

    def loads(self):
        return self.command, np.where(np.abs(self.external) < 0.01, 0.0, self.external)


class Unlogged(Wrapped):
    """Its column is written by steps alone, so that the first sample has none."""

    columns = (Column("count", 1, "", "Steps"),)

    def log(self, columns):
        self.steps = columns["count"]

    def after(self):
        self.steps[0] = self.count


class SwappedCables(Wrapped):
    def loads(self):
        return self.command[::-1], self.external


class Drifting(Wrapped):
    """The quaternion grows; in effect a tumbling body gains energy."""

    def after(self):
        state = self.inner.state.copy()
        state[10:] *= 1 + 1e-6
        self.put(state)


class Creeping(Wrapped):
    def after(self):
        state = self.inner.state.copy()
        state[2] -= 1e-10
        self.put(state)


class FrozenGeometry(Wrapped):
    """Runge-Kutta with the cables evaluated once a step: first order, declared fourth."""

    def loads(self):
        from cdpr.mechanics import kinematics

        wrench = kinematics.wrench_matrix(self.robot, self.inner.state) @ self.command
        return np.zeros(self.robot.m), self.external + wrench


class Replacing(Wrapped):
    """The state is a new array after each step."""

    def publish(self):
        self.state = self.inner.state.copy()


class Scribbling(Wrapped):
    """It clears the command that it was given."""

    def step(self, n):
        super().step(n)
        self.command[:] = 0.0


class Aliasing(Wrapped):
    """It keeps and changes the array that reset was given."""

    def reset(self, state):
        super().reset(state)
        state[0] += 1e-9


class Ageing(Wrapped):
    """Each one made in a process is a little worse than the one before."""

    made = 0

    def __init__(self, *arguments):
        super().__init__(*arguments)
        Ageing.made += 1
        self.fault = 1e-6 * Ageing.made

    def loads(self):
        return self.command, self.external + self.fault


class Unforgetting(Wrapped):
    """It keeps something of earlier steps over a reset."""

    residue = 0.0

    def loads(self):
        self.residue += 1e-9
        return self.command, self.external + self.residue


class Unladen(Wrapped):
    """It keeps the platform that it was made for."""

    def renew(self, robot):
        return True


class Sharing(Wrapped):
    """All plants of a process have one command."""

    shared = np.zeros(100)

    def loads(self):
        self.shared[: self.robot.m] += 1e-9 * self.command
        return self.command + self.shared[: self.robot.m], self.external


class HalfSnapshot(Wrapped):
    """The snapshot lacks the velocity."""

    def snapshot(self):
        return self.inner.state[:7].copy()

    def restore(self, snapshot):
        self.put(np.concatenate([snapshot, self.inner.state[7:]]))
        self.publish()


class RunningClock(Wrapped):
    """The clock is not set back by a reset."""

    ticks = 0

    def step(self, n):
        self.ticks += n
        super().step(n)

    def engine_time(self):
        return self.ticks * self.physics_step


class Chatting(Wrapped):
    def reset(self, state):
        print("pybullet build time: today")
        super().reset(state)


class NativeChatting(Wrapped):
    """Output of a library below Python."""

    def reset(self, state):
        os.write(2, b"Warning: unknown state\n")
        super().reset(state)


class Littering(Wrapped):
    def publish(self):
        if not np.isfinite(self.inner.state).all():
            Path("MUJOCO_LOG.TXT").write_text("bad state")
        super().publish()


class LeakingFiles(Wrapped):
    def reset(self, state):
        os.open(os.devnull, os.O_RDONLY)
        super().reset(state)


class LeakingMemory(Wrapped):
    kept = []  # noqa: RUF012 - that is the fault

    def close(self):
        self.kept.append(np.ones(50_000))


class Unguided(Wrapped):
    """It ignores guides: every platform moves freely."""

    def __init__(self, robot, gravity, physics_step, options):
        import dataclasses

        super().__init__(dataclasses.replace(robot, dof=("x", "y", "z", "rx", "ry", "rz")), gravity, physics_step, None)


class WrongHinge(Wrapped):
    """The hinge turns the other way round."""

    def publish(self):
        super().publish()
        if self.robot.n < 6:
            self.state[5] *= -1
            self.state[11] *= -1


class NoGuides(Wrapped):
    """An honest one: it refuses what it cannot do."""

    def __init__(self, robot, *rest):
        if robot.n < 6:
            raise PluginError("only free platforms")
        super().__init__(robot, *rest)


ORDER = {"order": 4}


# Broken backend -> what it declares, and the checks that must fail. It may fail others too.
MUTANTS = {
    **load_mutants.MUTANTS,
    **surroundings_mutants.MUTANTS,
    **anchor_mutants.MUTANTS,
    **winch_mutants.MUTANTS,
    Unlogged: ({}, ["columns_are_written"]),
    BodyFrameRead: ({}, ["state_round_trip", "state_is_current"]),
    BodyFrameBothWays: ({}, ["state_is_current", "tumbling_keeps_energy_and_momentum"]),
    Damping: ({}, ["coasting_keeps_velocity", "long_fall"]),
    Clamp: ({}, ["long_fall"]),
    Persistent: ({}, ["wrench_ends"]),
    Momentary: ({}, ["steps_add_up"]),
    Lag: ({}, ["state_is_current"]),
    AutoReset: ({}, ["nan_shows", "huge_wrench_shows"]),
    DroppedNan: ({}, ["nan_shows"]),
    Sleeping: ({}, ["coasting_keeps_velocity"]),
    LightSleep: ({}, ["coasts_however_slowly"]),
    LightSleepOfTurns: ({}, ["coasts_however_slowly"]),
    GravityUnderLoad: ({}, ["gravity_pulls_under_any_load"]),
    MomentsUnderLoad: ({}, ["loads_are_not_clamped"]),
    OwnGravity: ({}, ["gravity_pulls"]),
    WrenchInPlatformAxes: ({}, ["external_wrench_acts_on_the_origin"]),
    WrenchAtCentreOfMass: ({}, ["external_wrench_acts_on_the_origin", "hovers_in_balance"]),
    ClampedAtTheLimits: ({}, ["loads_are_not_clamped"]),
    DeadBand: ({}, ["loads_are_not_clamped"]),
    SwappedCables: ({}, ["cables_pull", "guided_wrench_accelerates"]),
    Drifting: ({}, ["tumbling_keeps_energy_and_momentum"]),
    Creeping: ({}, ["hovers_in_balance"]),
    FrozenGeometry: (ORDER, ["order_is_as_declared", "guided_order_is_as_declared", "spherical_order_is_as_declared"]),
    Replacing: ({}, ["arrays_are_kept"]),
    Scribbling: ({}, ["arrays_are_kept"]),
    Aliasing: ({}, ["state_round_trip"]),
    Ageing: ({}, ["made_and_closed_twice"]),
    Unforgetting: ({}, ["reset_forgets"]),
    Unladen: ({}, ["platform_is_renewed"]),
    Unread: ({}, ["operations_make_a_step"]),
    Sharing: ({}, ["instances_are_apart"]),
    HalfSnapshot: ({"snapshot": True}, ["snapshot_restores"]),
    RunningClock: ({}, ["clock_counts_steps"]),
    Chatting: ({}, ["keeps_quiet"]),
    NativeChatting: ({}, ["keeps_quiet"]),
    Littering: ({}, ["keeps_quiet"]),
    LeakingFiles: ({}, ["nothing_leaks"]),
    LeakingMemory: ({}, ["nothing_leaks"]),
    Unguided: (
        {},
        ["held_directions_stay", "guided_wrench_accelerates", "spherical_origin_stays", "spherical_wrench_accelerates"],
    ),
    WrongHinge: ({}, ["guided_state_round_trip", "spherical_state_round_trip"]),
}
