"""Differences between two runs of the same loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from cdpr.log.run import Run
from cdpr.model import rotations
from cdpr.model.robot import Array

# Two programs that compute the same scheme differ only by round-off. As shares of the scales below, the installed
# engines differ by at most 2e-13 in all our scenarios and 5e-14 in most (seconds of closed loop, 1 g to tonnes). This
# bound leaves room for longer runs, and any fault of an adapter exceeds it by far.
ROUND_OFF = 1e-10


@dataclass(frozen=True)
class Quantity:
    """Quantity by which two runs are compared.

    `scale` depends on the size of the robot and the forces in a run, so that a bound means the same for robots of grams
    and of tonnes. Angles are scaled by 1 rad, angular rates by 1 rad/s.
    """

    title: str
    unit: str
    scale: Callable[[Run], float]
    apart: Callable[[Run, Run], Array]  # (K,) of two runs with K samples
    deviation: Callable[[Run, Run], Array]  # (K, d); `apart` is its magnitude

    def allowed(self, standard: Run) -> float:
        """Return the largest difference from `standard` that round-off explains."""
        return ROUND_OFF * self.scale(standard)


def size(run: Run) -> float:
    """Return the mean length of the cables at the start, m."""
    return float(np.mean(run.length[0]))


def force(run: Run) -> float:
    """Return the largest tension or the platform's weight, whichever is larger, N."""
    weight = run.header.mass * float(np.linalg.norm(run.header.gravity))
    return max(weight, float(np.nanmax(np.abs(_tensions(run)), initial=0.0)))


def _tensions(run: Run) -> Array:
    """Return the commands and, if they differ, the tensions, (K, m) or (K, 2 m), N."""
    return run.tension if run.header.layout.ideal else np.hstack([run.tension, run.cable_tension])


def _change(name: str) -> Callable[[Run, Run], Array]:
    return lambda a, b: np.asarray(a[name] - b[name])


def _norm(name: str) -> Callable[[Run, Run], Array]:
    return lambda a, b: np.asarray(np.linalg.norm(a[name] - b[name], axis=1))


def _turn(a: Run, b: Run) -> Array:
    return rotations.between(a.orientation, b.orientation)


def _angle(a: Run, b: Run) -> Array:
    return np.asarray(np.linalg.norm(_turn(a, b), axis=1))


def _tension_change(a: Run, b: Run) -> Array:
    return np.asarray(_tensions(a) - _tensions(b))


def _tension(a: Run, b: Run) -> Array:
    """Return the largest tension difference over the cables, (K,), N."""
    return np.asarray(np.abs(_tension_change(a, b)).max(axis=1))


def _energy_change(a: Run, b: Run) -> Array:
    """Return the difference of the unexplained energy, (K, 1), J."""
    return np.asarray((a.energy_residual - b.energy_residual)[:, None])


def _energy(a: Run, b: Run) -> Array:
    return np.asarray(np.abs(_energy_change(a, b)[:, 0]))


QUANTITIES: Mapping[str, Quantity] = {
    "position": Quantity("position", "m", size, _norm("position"), _change("position")),
    "attitude": Quantity("attitude", "rad", lambda run: 1.0, _angle, _turn),
    "velocity": Quantity("velocity", "m/s", size, _norm("velocity"), _change("velocity")),
    "angular_velocity": Quantity(
        "angular velocity", "rad/s", lambda run: 1.0, _norm("angular_velocity"), _change("angular_velocity")
    ),
    "tension": Quantity("tension", "N", force, _tension, _tension_change),
    "energy": Quantity("energy balance", "J", lambda run: force(run) * size(run), _energy, _energy_change),
}
POSE = ("position", "attitude")


@dataclass(frozen=True)
class Difference:
    """Size of a difference over a run."""

    max: float
    rms: float
    time: float  # s, of the maximum


def apart(name: str, a: Run, b: Run) -> tuple[Array, Array]:
    """Return times and differences, both (K,), over the common samples; non-finite differences become infinite."""
    count = min(len(a.rows), len(b.rows))
    with np.errstate(all="ignore"):
        values = QUANTITIES[name].apart(head(a, count), head(b, count))
    return a.time[:count], np.where(np.isfinite(values), values, np.inf)


def head(run: Run, count: int) -> Run:
    """Return the first `count` samples of a run."""
    return run if len(run.rows) == count else Run(run.header, run.rows[:count])


def difference(name: str, a: Run, b: Run) -> Difference:
    """Return the size of the difference of two runs in the quantity `name`."""
    time, values = apart(name, a, b)
    if not len(values):
        return Difference(np.inf, np.inf, 0.0)
    worst = int(values.argmax())
    with np.errstate(over="ignore"):
        return Difference(float(values[worst]), float(np.sqrt(np.mean(values**2))), float(time[worst]))


def pose_apart(a: Run, b: Run) -> float:
    """Return the root mean square distance in pose, m; angles are multiplied by the robot's characteristic length."""
    arm = a.header.characteristic_length
    return float(np.hypot(difference("position", a, b).rms, arm * difference("attitude", a, b).rms))
