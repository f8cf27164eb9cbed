"""How far two runs of the same loop are apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from cdpr.log.run import Run
from cdpr.model import rotations
from cdpr.model.robot import Array

# Two programs that compute one scheme differ by round-off alone. As shares of the scales below, the installed engines
# differ by at most 2e-13 in any scenario of ours and 5e-14 in most (over seconds of closed loop, from 1 g to tonnes):
# this leaves room for longer runs and harder loops, and lies far below what any fault of an adapter makes.
ROUND_OFF = 1e-10


@dataclass(frozen=True)
class Quantity:
    """Something that two runs are compared by.

    `scale` is what it is measured by: of the size of the robot and of the forces in a run, so that a bound means the
    same for a robot of grams as for one of tonnes. Angles have the radian, rates the second.
    """

    title: str
    unit: str
    scale: Callable[[Run], float]
    apart: Callable[[Run, Run], Array]  # (K,) of two runs with K samples
    deviation: Callable[[Run, Run], Array]  # (K, d), of which `apart` is the size

    def allowed(self, standard: Run) -> float:
        """How far a run may be from `standard` by round-off."""
        return ROUND_OFF * self.scale(standard)


def size(run: Run) -> float:
    """Mean length of the cables at the start, m."""
    return float(np.mean(run.length[0]))


def force(run: Run) -> float:
    """Largest tension, or the platform's weight if that is more, N."""
    weight = run.header.mass * float(np.linalg.norm(run.header.gravity))
    return max(weight, float(np.nanmax(np.abs(_tensions(run)), initial=0.0)))


def _tensions(run: Run) -> Array:
    """Commands and, where they differ, tensions, (K, m) or (K, 2 m), N."""
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
    """Of the cable in which the two differ most."""
    return np.asarray(np.abs(_tension_change(a, b)).max(axis=1))


def _energy_change(a: Run, b: Run) -> Array:
    """Of the energy that no work explains."""
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
    """Times and differences, both (K,), over the samples that both runs have; what is not finite is infinite."""
    count = min(len(a.rows), len(b.rows))
    with np.errstate(all="ignore"):
        values = QUANTITIES[name].apart(head(a, count), head(b, count))
    return a.time[:count], np.where(np.isfinite(values), values, np.inf)


def head(run: Run, count: int) -> Run:
    """The first `count` samples of a run."""
    return run if len(run.rows) == count else Run(run.header, run.rows[:count])


def difference(name: str, a: Run, b: Run) -> Difference:
    """How far two runs are apart in the quantity `name`."""
    time, values = apart(name, a, b)
    if not len(values):
        return Difference(np.inf, np.inf, 0.0)
    worst = int(values.argmax())
    with np.errstate(over="ignore"):
        return Difference(float(values[worst]), float(np.sqrt(np.mean(values**2))), float(time[worst]))


def pose_apart(a: Run, b: Run) -> float:
    """Root mean square of the distance in pose, m: angles times the robot's characteristic length."""
    arm = a.header.characteristic_length
    return float(np.hypot(difference("position", a, b).rms, arm * difference("attitude", a, b).rms))
