"""Linear map of a control period of a closed loop."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Linearised:
    """Linear map of a control period about a state of rest, xi[k + 1] = A xi[k] + B w[k], with xi = x / scale.

    Attributes:
        A: (k, k), derivative by the state.
        corners: (k, k); the derivatives to both sides are A plus and minus this, 0 where the map is smooth. Tensions
            have corners at symmetric poses, where other cables reach their lower limits.
        B: (k, n), derivative by the desired pose in each degree of freedom [1/m, 1/rad].
        plant: (j, j), derivative of one physics step of the plant with held commands, by its first j coordinates.
        names: name of each coordinate: a degree of freedom or "winches", its rate as `x'`, "servo" or "controller",
            also for commands that wait in drives.
        scale: (k,), scales.
        rest: (k,), state of rest; of the platform relative to the desired pose.
        period: time after which the map repeats [s]: between two calls of the controller, or longer with measurements.
        physics_step: [s].
        notes: facts that limit its validity.
        seen_every: longest time between two measurements that the controller uses [s]; 0 if it sees the state itself.
    """

    A: Array
    corners: Array
    B: Array
    plant: Array
    names: tuple[str, ...]
    scale: Array
    rest: Array
    period: float
    physics_step: float
    notes: tuple[str, ...]
    seen_every: float = 0.0
