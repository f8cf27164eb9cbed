"""Energy of the platform and work of wrenches on it. See `cdpr.model` for the conventions."""

from __future__ import annotations

from numpy.typing import ArrayLike

from cdpr.native.compute import compute


def energy(inertial: ArrayLike, gravity: ArrayLike, state: ArrayLike) -> tuple[float, float]:
    """Compute the kinetic and the potential energy of the platform.

    With the centre of mass G, they are m |v_G|^2 / 2 + omega . I omega / 2 and -m g . p_G.

    Args:
        inertial: (13,) `Robot.inertial`.
        gravity: (3,) gravity [m/s^2], in world axes.
        state: (13,) state of the platform.

    Returns:
        Kinetic and potential energy [J]. The potential energy is 0 at the origin of the world frame.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> kinetic, potential = energy(robot.inertial, [0.0, 0.0, -9.81], [*robot.home, *[0.0] * 6])
        >>> kinetic, potential > 0.0
        (0.0, True)
    """
    _, (found,) = compute("energy", {"inertial": inertial, "gravity": gravity, "state": state}, {"energies": (2,)})
    return float(found[0]), float(found[1])


def external_work(wrench: ArrayLike, period: float, turn: ArrayLike, before: ArrayLike, after: ArrayLike) -> float:
    """Compute the work of a constant wrench on the platform between two states.

    The work of the force is exact. The work of the moment is moment . integral of omega. The integral is the rotation
    vector of the period plus period^2 / 12 omega_0 x omega_1 (second term of the Magnus expansion with omega linear in
    time). It is exact for a fixed axis, and otherwise of fourth order in the period.

    Args:
        wrench: (6,) force [N] and moment about the platform's origin [N m], in world axes.
        period: time between the states [s].
        turn: (3,) rotation vector between the states [rad], in world axes.
        before: (13,) first state.
        after: (13,) second state.

    Returns:
        Work [J].

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> before = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        >>> after = [0.0, 0.0, 0.5, *before[3:]]
        >>> external_work([0.0, 0.0, 2.0, 0.0, 0.0, 0.0], 0.001, [0.0, 0.0, 0.0], before, after)
        1.0
    """
    given = {"wrench": wrench, "turn": turn, "before": before, "after": after}
    _, (work,) = compute("external_work", given, {"work": (1,)}, period=period)
    return float(work[0])
