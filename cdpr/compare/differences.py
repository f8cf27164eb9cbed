"""How far two runs of the same loop are apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import yaml

from cdpr.log.run import Header, Run
from cdpr.model import rotations
from cdpr.model.robot import Array


@dataclass(frozen=True)
class Quantity:
    """Something that two runs are compared by.

    Two programs that compute the same scheme differ by round-off alone. `round_off` allows at least ten times what
    the installed engines differ by, and lies far below what any fault of an adapter makes. Most of it is for engines
    that keep the attitude as a rotation vector, good to 1e-9 rad. `lever` names the angle, or its rate, that comes on
    top of it where the centre of mass lies off the origin: engines move the centre of mass.
    """

    title: str
    unit: str
    round_off: float
    apart: Callable[[Run, Run], Array]  # (K,) of two runs with K samples
    lever: str = ""

    def allowed(self, header: Header) -> float:
        """Round-off for the platform of this run."""
        if not self.lever:
            return self.round_off
        centre = yaml.safe_load(header.scenario_yaml)["robot"]["platform"]["center_of_mass"]
        return self.round_off + float(np.linalg.norm(centre)) * QUANTITIES[self.lever].round_off


def _norm(name: str) -> Callable[[Run, Run], Array]:
    return lambda a, b: np.asarray(np.linalg.norm(a[name] - b[name], axis=1))


def _angle(a: Run, b: Run) -> Array:
    return np.asarray(np.linalg.norm(rotations.between(a.orientation, b.orientation), axis=1))


def _tension(a: Run, b: Run) -> Array:
    """Of the cable in which the two differ most."""
    return np.asarray(np.abs(a.tension - b.tension).max(axis=1))


def _energy(a: Run, b: Run) -> Array:
    """Of the energy that no work explains."""
    return np.asarray(np.abs(a.energy_residual - b.energy_residual))


QUANTITIES: Mapping[str, Quantity] = {
    "position": Quantity("position", "m", 1e-9, _norm("position"), "attitude"),
    "attitude": Quantity("attitude", "rad", 1e-6, _angle),
    "velocity": Quantity("velocity", "m/s", 1e-9, _norm("velocity"), "angular_velocity"),
    "angular_velocity": Quantity("angular velocity", "rad/s", 1e-7, _norm("angular_velocity")),
    "tension": Quantity("tension", "N", 1e-4, _tension),
    "energy": Quantity("energy balance", "J", 1e-6, _energy),
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
    size = a.header.characteristic_length
    return float(np.hypot(difference("position", a, b).rms, size * difference("attitude", a, b).rms))
