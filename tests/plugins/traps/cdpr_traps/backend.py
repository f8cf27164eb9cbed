"""Stepping traps, each a wrapper around a sound engine."""

from __future__ import annotations

import numpy as np

from cdpr.model import rotations
from cdpr.plugins import Backend
from cdpr.plugins.registry import registry


def make(robot, gravity, physics_step, options):
    """The chosen engine with the chosen fault."""
    return TRAPS[options.trap](robot, gravity, physics_step, options)


class Wrapped(Backend):
    """A backend step by step, with places to break it; the reference, unless options name another."""

    def __init__(self, robot, gravity, physics_step, options):
        super().__init__(robot, gravity, physics_step, options)
        entry = registry().get("backend", getattr(options, "engine", "reference"))
        self.inner = entry.make(robot, gravity, physics_step, entry.info.options())
        self.count = 0

    def reset(self, state):
        self.count = 0
        self.inner.reset(state)
        self.publish()

    def step(self, n):
        for _ in range(n):
            self.count += 1
            self.inner.command[:], self.inner.external[:] = self.loads()
            self.inner.step(1)
            self.after()
        self.publish()

    def load(self, robot):
        self.inner.load(robot)

    def engine_time(self):
        return self.count * self.physics_step

    def snapshot(self):
        return self.inner.snapshot(), self.count

    def restore(self, snapshot):
        inner, self.count = snapshot
        self.inner.restore(inner)
        self.publish()

    def close(self):
        self.inner.close()

    def loads(self):
        return self.command, self.external

    def after(self):
        pass

    def publish(self):
        self.state[:] = self.inner.state

    def put(self, state):
        """Continue from another state."""
        self.inner.reset(state)


def turned(state, inverse=False):
    R = rotations.matrix(state[3:7])
    out = state.copy()
    out[10:] = (R if inverse else R.T) @ state[10:]
    return out


class BodyFrameRead(Wrapped):
    """Frame: the angular velocity is read in platform axes."""

    def publish(self):
        self.state[:] = turned(self.inner.state)


class BodyFrameBothWays(BodyFrameRead):
    """Frame: read and written in platform axes, so that a round trip shows nothing."""

    def reset(self, state):
        super().reset(turned(state, inverse=True))


class Damping(Wrapped):
    """Damping: 0.04 per second, PyBullet's default."""

    def after(self):
        state = self.inner.state.copy()
        state[7:] *= 1 - 0.04 * self.physics_step
        self.put(state)


class Clamp(Wrapped):
    """Clamp: at 100 m/s, as in PyBullet."""

    def after(self):
        state = self.inner.state.copy()
        speed = np.linalg.norm(state[7:10])
        if speed > 100:
            state[7:10] *= 100 / speed
            self.put(state)


class Persistent(Wrapped):
    """Persistence: a wrench stays until another one replaces it."""

    last = np.zeros(6)

    def loads(self):
        if self.external.any():
            self.last = self.external.copy()
        return self.command, self.last


class Lag(Wrapped):
    """Lag: the pose is that of the step before, as MuJoCo's xpos."""

    pose = None

    def reset(self, state):
        self.pose = None
        super().reset(state)

    def step(self, n):
        self.pose = self.inner.state[:7].copy()
        super().step(n)

    def publish(self):
        super().publish()
        if self.pose is not None:
            self.state[:7] = self.pose


class AutoReset(Wrapped):
    """Auto-reset: from a bad state back to the start, clock and all, as MuJoCo by default."""

    def reset(self, state):
        self.start = np.array(state)
        super().reset(state)

    def after(self):
        if not np.isfinite(self.inner.state).all() or np.abs(self.inner.state).max() > 1e6:
            self.reset(self.start)


class DroppedNan(Wrapped):
    """Dropped NaN: a bad load is ignored, as in DART."""

    def loads(self):
        return tuple(np.where(np.isfinite(load), load, 0.0) for load in (self.command, self.external))


class Gravity(Wrapped):
    """Gravity: wrong by a ten-thousandth."""

    def __init__(self, robot, gravity, physics_step, options):
        super().__init__(robot, (1 + 1e-4) * gravity, physics_step, options)


class LightDamping(Wrapped):
    """Light damping: 0.001 per second."""

    def after(self):
        state = self.inner.state.copy()
        state[7:] *= 1 - 0.001 * self.physics_step
        self.put(state)


class Late(Wrapped):
    """Late: commands and wrenches act one physics step late."""

    last = None

    def reset(self, state):
        self.last = None
        super().reset(state)

    def loads(self):
        now = self.command.copy(), self.external.copy()
        acting, self.last = now if self.last is None else self.last, now
        return acting


TRAPS = {
    "none": Wrapped,
    "frame": BodyFrameBothWays,
    "damping": Damping,
    "clamp": Clamp,
    "persistence": Persistent,
    "lag": Lag,
    "auto_reset": AutoReset,
    "dropped_nan": DroppedNan,
    "gravity": Gravity,
    "light_damping": LightDamping,
    "late": Late,
}
