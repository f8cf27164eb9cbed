"""Largest stable steps for a platform on elastic cables and drums.

Let z be the free directions of the platform and the unstretched lengths. About a pose, M z'' + C z' + K z = 0. The
elongations are -B^T z with B = [W; 1], so that K = B k B^T and C = B d B^T + friction. M contains the inertia of the
platform and I / r^2 of each drum. Drums of rigid cables move with the platform, so only their friction remains. The
stiffness that tensions add across the cables is far below k and is neglected.

The unstretched length of an ideal drive does not depend on the motion, and is no coordinate; nor is that of a stepper
without an inertia. A servo without a lag adds (kv kp + ki) / r^2 to the stiffness and kv / r^2 to the damping of its
unstretched length (`cdpr.cables.servo`; the slow part ki kp of the integral is neglected). A stepper with an inertia
adds the slope of its torque, pi M_s / (2 a r^2), to the stiffness (`cdpr.cables.stepper`). A pulley with friction
damps its drum, or the platform if the cable does not stretch, in proportion to the tension. So do the losses of a
transmission, as at rest. The tension is estimated by the least squares that carry the weight, and at least the lower
limit. Other own states of winches are not included: a motor with a lag is taken to hold its torque.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cdpr.cables import chain_of, rubs
from cdpr.cables.chain import Chain, Winch
from cdpr.cables.drums import drum_motion
from cdpr.cables.ideal_drive import IDEAL_DRIVE
from cdpr.cables.servo import POSITION_SERVO, VELOCITY_SERVO
from cdpr.cables.stepper import STEPPER, STEPPER_MOTOR
from cdpr.cables.transmission import COULOMB_SPEED, EFFICIENCY
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import STILL, lengths, wrench_matrix
from cdpr.mechanics.limiting_part import Resistance
from cdpr.model import Cable, Robot, rotations
from cdpr.model.robot import Array

PRESCRIBED = (IDEAL_DRIVE, STEPPER)  # winches whose drums do not depend on the motion

# Motion without resistance has the eigenvalue 1 twice. Eigenvalues resolve it only to the root of their round-off.
GROWTH = 1e-6
GRAVITY = 0.0, 0.0, -9.81  # m/s^2


@dataclass(frozen=True, eq=False)
class Oscillator:
    """Linear oscillator M z'' + C z' + K z = 0 with matrices (k, k).

    Numbers out of the range of floating-point numbers yield NaN or infinity, without warnings; `stable` rejects them.
    The sum of the `parts` is that of K and C.
    """

    M: Array
    C: Array
    K: Array
    parts: tuple[Resistance, ...]

    @property
    def fastest(self) -> float:
        """Largest natural frequency without damping [rad/s]."""
        return float(np.sqrt(_radius(self._slopes()[:, : len(self.M)])))

    @np.errstate(all="ignore")
    def _slopes(self) -> Array:
        """Return the matrix (k, 2 k) of -z'' on (z, z')."""
        try:
            return np.asarray(np.linalg.solve(self.M, np.hstack([self.K, self.C])))
        except np.linalg.LinAlgError:  # singular
            return np.full((len(self.M), 2 * len(self.M)), np.inf)

    @np.errstate(all="ignore")
    def semi_implicit(self, h: float) -> Array:
        """Return the matrix (2 k, 2 k) on (z, z') of one step of the semi-implicit Euler scheme."""
        one, zero = np.eye(len(self.M)), np.zeros_like(self.M)
        pull = self._slopes()
        rates = np.hstack([zero, one]) - h * pull
        return np.vstack([np.hstack([one, zero]) + h * rates, rates])

    @np.errstate(all="ignore")
    def runge_kutta(self, h: float) -> Array:
        """Return the matrix (2 k, 2 k) on (z, z') of one step of the classical Runge-Kutta scheme."""
        one, zero = np.eye(len(self.M)), np.zeros_like(self.M)
        A = h * np.vstack([np.hstack([zero, one]), -self._slopes()])
        step = term = np.eye(len(A))
        for power in range(1, 5):
            term = term @ A / power
            step = step + term
        return step

    @np.errstate(all="ignore")
    def gauss_seidel(self, h: float, n: int, semi_implicit: bool) -> Array:
        """Return the matrix (2 k, 2 k) on (z, z') of one step of the platform, then of the winches.

        The first n coordinates are those of the platform. It moves under constant tensions, by the semi-implicit Euler
        scheme or exactly. The winches then move by the classical Runge-Kutta scheme, with the platform at the middle of
        its step.
        """
        k = len(self.M)
        x, v, s = slice(0, n), slice(k, k + n), [*range(n, k), *range(k + n, 2 * k)]
        pull = -self._slopes()  # z'' of (z, z')
        platform = np.eye(2 * k)
        platform[v] += h * pull[:n]
        platform[x, v] += h * np.eye(n)
        platform[x] += h * h * (1.0 if semi_implicit else 0.5) * pull[:n]
        half = np.eye(2 * k)
        half[[*range(n), *range(k, k + n)]] = 0.5 * (platform + np.eye(2 * k))[[*range(n), *range(k, k + n)]]
        A = np.zeros((2 * k, 2 * k))  # slope of the winches
        A[n:k, k + n :] = np.eye(k - n)
        A[k + n :] = pull[n:]
        step = term = np.eye(2 * k)
        for power in range(1, 5):
            term = term @ (h * A) / power
            step = step + term
        platform[s] = step[s] @ half
        return platform


def supports_oscillator(robot: Robot) -> bool:
    """Return True if `oscillator` supports all winches.

    It supports ideal drives, immediate winches, and those that declare radius and inertia of a drum.
    """
    winches = [chain_of(robot, cable).winch for cable in robot.cables]
    known = (
        winch in PRESCRIBED or {"drum_radius", "inertia"} <= _keys(winch) for winch in winches if not winch.immediate
    )
    return all(known)


def _keys(winch: Winch) -> set[str]:
    return {number.key for number in winch.numbers if number.owner == "winch"}


def _loops(chain: Chain, cable: Cable) -> tuple[float, float]:
    """Return stiffness [N m] and damping [N m s] about the drum's axis that a servo or a stepper adds."""
    if chain.winch not in (POSITION_SERVO, VELOCITY_SERVO, STEPPER_MOTOR):
        return 0.0, 0.0
    gains = {number.key: number.of(cable) for number in chain.winch.numbers}
    if chain.winch is STEPPER_MOTOR:
        return gains["stall_torque"] * gains["steps_per_turn"] * gains["gear_ratio"] / 4.0, 0.0  # pi / 2 per full step
    if gains["torque_lag"] > 0.0:
        return 0.0, 0.0
    position = gains["position_gain"] if chain.winch.command == "length" else 0.0
    return gains["velocity_gain"] * position + gains["integral_gain"], gains["velocity_gain"]


@np.errstate(all="ignore")
def oscillator(robot: Robot, state: Array, gravity: ArrayLike = GRAVITY) -> Oscillator:
    """Linearise a robot on winches with `supports_oscillator` about the pose of a state with all cables taut.

    Args:
        robot: the robot.
        state: (13,), only its pose is used.
        gravity: (3,) m/s^2, for the estimate of the tensions.
    """
    rows, W, length = robot.rows, wrench_matrix(robot, state)[robot.rows], lengths(robot, state)
    still = np.concatenate([state[:7], np.zeros(6)])
    columns = [required_wrench(robot, still, STILL, e[:3], e[3:]) for e in np.eye(6)[rows]]
    mass = np.array(columns).T[rows]
    chains = [chain_of(robot, cable) for cable in robot.cables]
    per_turn = drum_motion(robot, length[None], np.zeros((1, robot.m)), np.zeros((1, robot.m))).per_turn[0]
    weight = required_wrench(robot, still, np.asarray(gravity, float))[rows]
    tension = np.maximum(np.linalg.lstsq(W, weight, rcond=None)[0], robot.tension_min)
    drums, losses, gains = np.zeros(robot.m), np.zeros(robot.m), np.zeros(robot.m)
    servos = np.zeros(robot.m)  # damping of servos, part of the losses
    for i, (cable, chain) in enumerate(zip(robot.cables, chains, strict=True)):
        winch = cable.winch
        if winch is not None and not chain.immediate and chain.winch not in PRESCRIBED:
            radius = per_turn[i]
            drums[i] = winch.inertia / radius**2
            gain, loss = _loops(chain, cable)
            keys = _keys(chain.winch)
            if "viscous_friction" in keys:
                loss += winch.viscous_friction
            if {"coulomb_friction", "coulomb_speed"} <= keys:
                loss += winch.coulomb_friction / winch.coulomb_speed
            if EFFICIENCY in chain.winch.transmission and (efficiency := EFFICIENCY.of(cable)) < 1.0:
                share = 2.0 * (1.0 - efficiency) / (1.0 + efficiency)
                loss += share * radius * tension[i] / COULOMB_SPEED.of(cable)
            losses[i], gains[i] = loss / radius**2, gain / radius**2
            servos[i] = _loops(chain, cable)[1] / radius**2
    rubbing = _losses_on_exits(robot, state, tension)
    own_losses, losses = losses - servos, losses + rubbing
    springs = np.array([chain.stretches for chain in chains])
    own = springs & [chain.winch not in PRESCRIBED for chain in chains]  # drums with their own coordinates
    carried, n, k = W[:, ~springs], len(W), int(own.sum())
    B = np.vstack([W[:, springs], np.eye(robot.m)[own][:, springs]])
    M, C, K = (np.zeros((n + k, n + k)) for _ in range(3))
    M[:n, :n], M[n:, n:] = mass + carried * drums[~springs] @ carried.T, np.diag(drums[own])
    C[:n, :n], C[n:, n:] = carried * losses[~springs] @ carried.T, np.diag(losses[own])
    K[n:, n:] = np.diag(gains[own])
    axial = [chain.span.stiffest(cable) for chain, cable in zip(chains, robot.cables, strict=True)]
    stiffness = np.array(axial)[springs] / length[springs]
    damping = np.array([cable.damping for cable in robot.cables])[springs]
    along = (np.eye(n + k)[:, :n] @ carried).T  # directions of cables that do not stretch
    parts = (
        *_of_springs(np.flatnonzero(springs).tolist(), B.T, stiffness, damping),
        *_of_drums(np.flatnonzero(own).tolist(), np.eye(n + k)[n:], gains, servos, own_losses, rubbing),
        *_of_drums(np.flatnonzero(~springs).tolist(), along, gains, servos, own_losses, rubbing),
    )
    return Oscillator(M, C + B * damping @ B.T, K + B * stiffness @ B.T, parts)


def _of_springs(cables: list[int], directions: Array, stiffness: Array, damping: Array) -> Iterator[Resistance]:
    for i, direction, spring, damper in zip(cables, directions, stiffness, damping, strict=True):
        yield Resistance(i, "its stiffness", direction, stiffness=spring)
        yield Resistance(i, "its damping", direction, damping=damper)


def _of_drums(
    cables: list[int], directions: Array, gains: Array, servos: Array, losses: Array, rubbing: Array
) -> Iterator[Resistance]:
    for i, direction in zip(cables, directions, strict=True):
        yield Resistance(i, "the control of its winch", direction, gains[i], servos[i])
        yield Resistance(i, "the friction of its winch", direction, damping=losses[i])
        yield Resistance(i, "the friction of its pulley", direction, damping=rubbing[i])


def _losses_on_exits(robot: Robot, state: Array, tension: Array) -> Array:
    """Return the damping (m,) [N s/m] of the cables by friction on their exits, under tensions (m,) [N], at rest."""
    return exit_slopes(robot, state) * tension if rubs(robot) else np.zeros(robot.m)


def exit_slopes(robot: Robot, state: Array) -> Array:
    """Return the damping (m,) of the cables by friction on their exits, per tension [s/m], at the pose of a state."""
    tips = state[:3] + robot.anchors[:, 3:] @ rotations.matrix(state[3:7]).T
    slopes = [
        cable.exit.damping(cable.frame.tolist(), tip.tolist()) if cable.exit else 0.0
        for cable, tip in zip(robot.cables, tips, strict=True)
    ]
    return np.array(slopes)


def shortest_lag(robot: Robot) -> tuple[float, str]:
    """Return the shortest time constant of the torque of a servo [s], infinite without any, and the name of its cable.

    Without more, it requires steps of at most twice its value.
    """
    lags = [
        (number.of(cable), cable.name)
        for cable in robot.cables
        for number in chain_of(robot, cable).winch.numbers
        if number.key == "torque_lag" and number.of(cable) > 0.0
    ]
    return min(lags, key=lambda each: each[0], default=(np.inf, ""))


def shortest_creep(robot: Robot) -> float:
    """Return the shortest time in which the tension of a cable relaxes by creep [s], infinite without any.

    Steps of at most this value settle, also together with the vibration of the cable.
    """
    return min((chain_of(robot, cable).span.shortest_time(cable) for cable in robot.cables), default=np.inf)


def stable(step: Array) -> bool:
    """Return True if repeated steps (k, k) do not grow; False for steps that are not finite."""
    return _radius(step) <= 1.0 + GROWTH


def _radius(matrix: Array) -> float:
    """Return the spectral radius of a matrix (k, k); infinite if its numbers are not finite."""
    return float(np.abs(np.linalg.eigvals(matrix)).max()) if np.isfinite(matrix).all() else np.inf


def longest(scheme: Callable[[float], Array], too_long: float) -> float:
    """Return the longest stable step [s], rounded down to two digits; 0 if none above 1e-9 s is stable.

    The search starts from `too_long`, a step that is not stable.
    """
    step = too_long
    while step > 1e-9 and not stable(scheme(step)):
        step *= 0.9
    if step <= 1e-9:
        return 0.0
    digit = 10.0 ** (np.floor(np.log10(step)) - 1.0)
    return float(np.floor(step / digit) * digit)
