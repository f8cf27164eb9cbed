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
from cdpr.model.jit import any_width, kernel
from cdpr.model.kernels import conjugate, logarithm, multiply, quaternion
from cdpr.model.lanes import choose, code, every, some
from cdpr.model.robot import Array
from cdpr.simulation.faults import JUMPED, LENGTH_MIN, NO_LENGTH, NO_LENGTH_BELIEVED, NO_UNIT, NOT_FINITE, TOO_FAST

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
    before: Array  # (m,), m, work space


def observing(body: Body, shown: Shown, seen: Seen, period: float) -> Callable[[], int]:
    """Return what writes what is `seen` of the plant, and returns 0 or a key of FAULTS.

    State and lengths in it are before those of one control `period` (s) ago. A tension that is held does exactly
    tension times shortening; a period of 0 sets the works to 0. (To take bundles apart anew costs a kernel five times
    what this one costs: it takes their arrays.)
    """
    return partial(observe, *body, *shown, *seen, period)


@any_width
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
    before: Array,
    period: float,
) -> int:
    """Do what `observing` says; the arrays are those of `Body`, `Shown` and `Seen`, in their order.

    Where there is a fault, state, lengths and energies stay as they were.
    """
    m = lines.shape[0]
    q = quaternion(live, 3)
    finite, speed, spin, jump, twist, push, torque = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(13):
        finite += 0.0 * live[i]
    turn = logarithm(multiply(q, conjugate(quaternion(state, 3))))
    for i in range(3):
        v, w, past = live[7 + i], live[10 + i], state[10 + i]
        moved, turned = live[i] - state[i] - period * v, turn[i] - period * w
        speed += v * v
        spin += max(w * w, past * past)
        jump += moved * moved
        twist += turned * turned
        push += external[i] * external[i]
        torque += external[3 + i] * external[3 + i]
    pull = math.sqrt(push)
    for i in range(m):
        pull += abs(highest[i])
    arm = bounds[2]
    angular = (bounds[3] * pull + math.sqrt(torque)) * bounds[4] + bounds[5] * spin
    central = pull * bounds[0] + bounds[1]  # of the centre of mass
    swings = bounds[6] > 0.0
    if some(swings):
        # Gauss's principle: held, mass * central^2 + angular * inertia * angular is not more than it would be free.
        moment = bounds[4] / bounds[0]  # mass / smallest principal moment
        whole = central + arm * spin
        free = moment * (whole * whole) + (1.0 + bounds[5]) * (angular * angular)
        angular, central = choose(swings, math.sqrt(free), angular), choose(swings, math.sqrt(free / moment), central)
    linear = central + arm * (angular + spin)
    jumped = math.sqrt(jump) > period * (JUMP_SPEED + JUMP_FACTOR * period * linear)
    # A turn by more than pi comes back as its shorter twin: only smaller ones can be compared.
    comparable = period * math.sqrt(spin) < 1.0
    spun = math.sqrt(twist) > period * (JUMP_SPEED + JUMP_FACTOR * period * angular)
    fast = (speed > SPEED_MAX * SPEED_MAX) | (spin > ANGULAR_SPEED_MAX * ANGULAR_SPEED_MAX)
    stretch = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0
    fault = choose(abs(stretch) > NORM_TOLERANCE, NO_UNIT, 0)
    fault = choose(fast, TOO_FAST, choose(jumped | (comparable & spun), JUMPED, fault))
    work = 0.0
    for i in range(m):
        before[i] = length[i]
        work += highest[i] * length[i]
    if some(finite == 0.0):
        cable_geometry(lines, live, W, length, rate)
    for i in range(m):
        work -= highest[i] * length[i]
        fault = choose(length[i] > LENGTH_MIN, fault, NO_LENGTH)
    fault = choose(finite == 0.0, fault, NOT_FINITE)
    if some(fault != 0):
        for i in range(m):
            length[i] = choose(fault != 0, before[i], length[i])
    if not every(fault != 0):
        kinetic, potential = energy(inertial, gravity, live)
        work, push = energies[2] + work, energies[3] + external_work(external, period, turn, state, live)
        if period == 0.0:
            work, push = 0.0, 0.0
        energies[0], energies[1] = choose(fault != 0, energies[0], kinetic), choose(fault != 0, energies[1], potential)
        energies[2], energies[3] = choose(fault != 0, energies[2], work), choose(fault != 0, energies[3], push)
        for i in range(13):
            state[i] = choose(fault != 0, state[i], live[i])
    return code(fault)


@any_width
@kernel
def believe(lines: Array, state: Array, W: Array, length: Array, rate: Array) -> int:
    """Write wrench matrix (6, m), lengths and rates (m,) of the believed robot; return 0 or a key of FAULTS."""
    cable_geometry(lines, state, W, length, rate)
    fault = 0.0
    for i in range(length.shape[0]):
        fault = choose(length[i] > LENGTH_MIN, fault, NO_LENGTH_BELIEVED)
    return code(fault)


@any_width
@kernel
def exert(W: Array, tension: Array, wrench: Array) -> None:
    """Write the wrench (6,) W @ tension."""
    for j in range(6):
        wrench[j] = 0.0
        for i in range(tension.shape[0]):
            wrench[j] += W[j, i] * tension[i]
