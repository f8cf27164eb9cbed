"""Energy of the platform, and the work that is done on it. Conventions: see `cdpr.model`."""

from __future__ import annotations

from numpy.typing import ArrayLike

from cdpr.native.compute import compute


def energy(inertial: ArrayLike, gravity: ArrayLike, state: ArrayLike) -> tuple[float, float]:
    """Compute the kinetic and the potential energy of the platform.

    With G the centre of mass: m |v_G|^2 / 2 + omega . I omega / 2, and -m g . p_G.

    Args:
        inertial: (13,), `Robot.inertial`.
        gravity: (3,) m/s^2, world.
        state: (13,).

    Returns:
        Kinetic and potential energy, J; the latter is 0 at the world's origin.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> kinetic, potential = energy(robot.inertial, [0.0, 0.0, -9.81], state)
    """
    _, (found,) = compute("energy", {"inertial": inertial, "gravity": gravity, "state": state}, {"energies": (2,)})
    return float(found[0]), float(found[1])


def external_work(wrench: ArrayLike, period: float, turn: ArrayLike, before: ArrayLike, after: ArrayLike) -> float:
    """Compute the work of a constant wrench on the platform between two states.

    That of the force is exact. That of the moment is moment . integral of omega, and that integral is the rotation
    vector of the period plus period^2 / 12 omega_0 x omega_1 (second term of the Magnus expansion, with omega linear in
    time): exact about a fixed axis, else of fourth order in the period.

    Args:
        wrench: (6,) N and N m, about the platform's origin, world axes.
        period: Time between the states, s.
        turn: (3,) rad, rotation vector between the states, world axes.
        before: (13,), state.
        after: (13,), state.

    Returns:
        Work, J.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> work = external_work([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], 0.001, [0.0, 0.0, 0.0], before, after)
    """
    given = {"wrench": wrench, "turn": turn, "before": before, "after": after}
    _, (work,) = compute("external_work", given, {"work": (1,)}, period=period)
    return float(work[0])
