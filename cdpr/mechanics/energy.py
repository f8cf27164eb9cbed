"""Energy of the platform, and the work that is done on it. Conventions: see `cdpr.model`."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.kernels import Vector, conjugate, cross, dot, product, quaternion, rotate, vector
from cdpr.model.robot import Array


@kernel
def energy(inertial: Array, gravity: Array, state: Array) -> tuple[float, float]:
    """Kinetic and potential energy, J, of the platform at `state` (13,); `inertial` is as `Robot` says.

    With G the centre of mass: m |v_G|^2 / 2 + omega . I omega / 2, and -m g . p_G, which is 0 at the world's origin.
    """
    q, omega = quaternion(state, 3), vector(state, 10)
    r = rotate(q, vector(inertial, 1))
    swing = cross(omega, r)
    v = (state[7] + swing[0], state[8] + swing[1], state[9] + swing[2])
    w = rotate(conjugate(q), omega)
    height = gravity[0] * (state[0] + r[0]) + gravity[1] * (state[1] + r[1]) + gravity[2] * (state[2] + r[2])
    return 0.5 * (inertial[0] * dot(v, v) + dot(w, product(inertial, 4, w))), -inertial[0] * height


@kernel
def external_work(external: Array, period: float, turn: Vector, before: Array, after: Array) -> float:
    """Work, J, of a constant wrench (6,) at the origin, world axes, over a `period` between two states (13,).

    The force's is exact. The moment's is moment . integral of omega, and that integral is the rotation vector `turn`
    of the period plus period^2 / 12 omega_0 x omega_1 (second term of the Magnus expansion, with omega linear in time):
    exact about a fixed axis, else of fourth order in the period; the rotation vector alone would be of second.
    """
    work = 0.0
    drift = cross(vector(before, 10), vector(after, 10))
    for i in range(3):
        work += external[i] * (after[i] - before[i])
        work += external[3 + i] * (turn[i] + period * period / 12.0 * drift[i])
    return work
