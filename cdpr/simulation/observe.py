"""What the loop computes from each new state: cable geometry, energies, and whether the state can be true."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from cdpr.mechanics.energy import energy, external_work
from cdpr.mechanics.geometry import cable_geometry
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, logarithm, multiply, quaternion
from cdpr.model.robot import Array
from cdpr.simulation.faults import LENGTH_MIN, NO_LENGTH, NO_LENGTH_BELIEVED, NOT_FINITE

# Faster than any cable robot by two orders: whoever gets there has diverged.
SPEED_MAX = 1e3  # m/s
ANGULAR_SPEED_MAX = 1e4  # rad/s

# Quaternions are renormalised by every engine each step; this is far above round-off, far below a usable attitude.
NORM_TOLERANCE = 1e-6

# A step of the pose may differ from the velocity after it by as much as the strongest acceleration allows, and by this
# factor, for schemes that do not know the velocity in between; plus what round-off and attitude maps leave.
JUMP_FACTOR = 2.0
JUMP_SPEED = 1e-6  # m/s and rad/s


def acceleration_bounds(robot: Robot, gravity: Array) -> Array:
    """What bounds the platform's accelerations, (7,), for `observe`.

    1 / mass; |gravity|; distance of the centre of mass from the origin; largest distance at which a cable or a wrench
    at the origin acts from the centre of mass; 1 / smallest principal moment; largest ratio of the gyroscopic
    angular acceleration to the squared angular speed; 1 where the force that holds the origin turns the platform, as
    that of a pendulum, else 0.
    """
    platform = robot.platform
    moments = np.linalg.eigvalsh(platform.inertia)
    arm = float(np.linalg.norm(platform.center_of_mass))
    reach = float(np.linalg.norm(robot.anchors[:, 3:] - platform.center_of_mass, axis=1).max())
    ratio = (moments[2] - moments[0]) / moments[0]
    weight = float(np.linalg.norm(gravity))
    turns = sum(name.startswith("r") for name in robot.dof)
    swings = arm > 0.0 and turns > 0 and robot.n - turns < 3
    return np.array([1.0 / platform.mass, weight, arm, max(reach, arm), 1.0 / moments[0], ratio, swings])


class Body(NamedTuple):
    """What moves, of a robot with m cables."""

    lines: Array  # as `cdpr.cables.lines` says
    inertial: Array  # (13,), as `Robot.inertial`
    gravity: Array  # (3,), m/s^2
    bounds: Array  # (7,), as `acceleration_bounds` says


class Shown(NamedTuple):
    """What a backend shows, live."""

    state: Array  # (13,)
    external: Array  # (6,), what acted in the control period before, N and N m
    highest: Array  # (m,), N, no tension was above it; with ideal cables it is what they had


class Seen(NamedTuple):
    """What is computed from it, in the present sample."""

    state: Array  # (13,)
    W: Array  # (6, m)
    length: Array  # (m,), m
    rate: Array  # (m,), m/s
    energies: Array  # (4,), J: kinetic, potential, and the works so far of ideal cables and of the external wrench


def observing(body: Body, shown: Shown, seen: Seen, period: float) -> Callable[[], int]:
    """Return what writes what is `seen` of the plant, and returns 0 or a key of FAULTS.

    State and lengths in it are before those of one control `period` (s) ago. A tension that is held does exactly
    tension times shortening; a period of 0 sets the works to 0. (To take bundles apart anew costs a kernel five times
    what this one costs: it takes their arrays.)
    """
    return partial(observe, *body, *shown, *seen, period)


@kernel
def observe(
    lines: Array,
    inertial: Array,
    gravity: Array,
    bounds: Array,
    live: Array,
    external: Array,
    highest: Array,
    state: Array,
    W: Array,
    length: Array,
    rate: Array,
    energies: Array,
    period: float,
) -> int:
    """Do what `observing` says; the arrays are those of `Body`, `Shown` and `Seen`, in their order."""
    fault = 0
    for i in range(13):
        if not math.isfinite(live[i]):
            fault = NOT_FINITE
    if fault == 0:
        q = quaternion(live, 3)
        if abs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) > NORM_TOLERANCE:
            fault = 2
        speed, spin, jump, twist, push, torque = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        turn = logarithm(multiply(q, conjugate(quaternion(state, 3))))
        for i in range(3):
            v, w = live[7 + i], live[10 + i]
            speed += v * v
            spin += max(w * w, state[10 + i] ** 2)
            jump += (live[i] - state[i] - period * v) ** 2
            twist += (turn[i] - period * w) ** 2
            push += external[i] ** 2
            torque += external[3 + i] ** 2
        pull = math.sqrt(push)
        for i in range(lines.shape[0]):
            pull += abs(highest[i])
        arm = bounds[2]
        angular = (bounds[3] * pull + math.sqrt(torque)) * bounds[4] + bounds[5] * spin
        central = pull * bounds[0] + bounds[1]  # of the centre of mass
        if bounds[6] > 0.0:
            # Gauss's principle: held, mass * central^2 + angular * inertia * angular is not more than it would be free.
            moment = bounds[4] / bounds[0]  # mass / smallest principal moment
            free = moment * (central + arm * spin) ** 2 + (1.0 + bounds[5]) * angular**2
            angular, central = math.sqrt(free), math.sqrt(free / moment)
        linear = central + arm * (angular + spin)
        # A turn by more than pi comes back as its shorter twin: only smaller ones can be compared.
        comparable = period * math.sqrt(spin) < 1.0
        if speed > SPEED_MAX * SPEED_MAX or spin > ANGULAR_SPEED_MAX * ANGULAR_SPEED_MAX:
            fault = 3
        elif math.sqrt(jump) > period * (JUMP_SPEED + JUMP_FACTOR * period * linear) or (
            comparable and math.sqrt(twist) > period * (JUMP_SPEED + JUMP_FACTOR * period * angular)
        ):
            fault = 4
        work = 0.0
        for i in range(lines.shape[0]):
            work += highest[i] * length[i]
        cable_geometry(lines, live, W, length, rate)
        for i in range(lines.shape[0]):
            work -= highest[i] * length[i]
            if not length[i] > LENGTH_MIN:
                fault = NO_LENGTH
        energies[0], energies[1] = energy(inertial, gravity, live)
        if period > 0.0:
            energies[2] += work
            energies[3] += external_work(external, period, turn, state, live)
        else:
            energies[2], energies[3] = 0.0, 0.0
    for i in range(13):
        state[i] = live[i]
    return fault


@kernel
def believe(lines: Array, state: Array, W: Array, length: Array, rate: Array) -> int:
    """Write wrench matrix (6, m), lengths and rates (m,) of the believed robot; return 0 or a key of FAULTS."""
    cable_geometry(lines, state, W, length, rate)
    for i in range(length.shape[0]):
        if not length[i] > LENGTH_MIN:
            return NO_LENGTH_BELIEVED
    return 0


@kernel
def exert(W: Array, tension: Array, wrench: Array) -> None:
    """Write the wrench (6,) W @ tension."""
    for j in range(6):
        wrench[j] = 0.0
        for i in range(tension.shape[0]):
            wrench[j] += W[j, i] * tension[i]
