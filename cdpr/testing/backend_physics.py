"""Checks of a backend by the equations of motion of a free platform."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.mechanics import dynamics
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array
from cdpr.simulation.observe import ANGULAR_SPEED_MAX, SPEED_MAX
from cdpr.testing import samples
from cdpr.testing.check import Check, Failed, expect, expect_close, needs
from cdpr.testing.samples import GRAVITY, NO_GRAVITY
from cdpr.testing.subjects import BackendSubject

SHORT = 1e-5  # s; one such step from rest gives the acceleration with any consistent scheme
ONE_STEP = 1e-6  # relative tolerance of such an acceleration
SLOW = 1e-5, 1e-7, 1e-9  # m/s and rad/s; engines put bodies to sleep below 1e-2
LOADS = 1e-3, 1.0, 1e2, 1e3, 3e3, 1e4, 1e5  # N and N m, of cables and of wrenches
STALE = 1e-4  # m, rad, m/s, rad/s: above the error of a step of 1 ms, far below the motion in a step

NO_COMMAND = np.zeros(8)
NO_WRENCH = np.zeros(6)


def state_round_trip(subject: BackendSubject) -> None:
    """After `reset(start)`, `state` equals `start`, in any attitude.

    The plant copies the array `start`, and does not change it.
    """
    rng = np.random.default_rng(10)
    backend = subject.make(samples.state(rng))
    for _ in range(100):
        given = samples.state(rng, speed=3.0)
        kept = given.copy()
        backend.reset(given)
        expect_close(given, kept, 0.0, "the array given to reset")
        given[:] = 0.0  # the backend must have copied it
        q = backend.state[3:7]
        sign = 1.0 if q @ kept[3:7] > 0.0 else -1.0
        expect_close(backend.state[[0, 1, 2]], kept[:3], 1e-11, "position, m")
        expect_close(sign * q, kept[3:7], 1e-11, "attitude quaternion")
        expect_close(backend.state[7:10], kept[7:10], 1e-11, "velocity of the origin, m/s, world axes")
        expect_close(backend.state[10:], kept[10:], 1e-11, "angular velocity, rad/s, world axes")


def state_is_current(subject: BackendSubject) -> None:
    """After a step, `state` contains pose and twist at the end of this step, not those at its start."""
    rng = np.random.default_rng(11)
    start = samples.state(rng)
    start[7:] = [8.0, -5.0, 6.0, 3.0, -2.0, 4.0]
    backend = subject.make(start)
    backend.step(1)
    end = samples.travel(samples.free(), start, GRAVITY, NO_COMMAND, NO_WRENCH, 1e-3, 1e-3)
    expect_close(samples.distance(backend.state, end), 0.0, STALE, "state after one step of 1 ms at 11 m/s")


def gravity_pulls(subject: BackendSubject) -> None:
    """If only gravity acts, the acceleration of the platform is the gravity vector.

    The kit tests several directions of this vector, and a gravity of zero.
    """
    for gravity in (np.array([0.0, 0.0, -9.81]), np.array([1.0, 2.0, -5.0]), np.zeros(3)):
        _accelerates(subject, gravity, NO_COMMAND, NO_WRENCH, "acceleration by gravity")


def external_wrench_acts_on_the_origin(subject: BackendSubject) -> None:
    """`external` acts as a force at the origin of the platform and a moment, both in world axes.

    The inertia tensor in this check has products of inertia (entries off the diagonal).
    """
    for k, part in enumerate(np.eye(6)):
        _accelerates(subject, NO_GRAVITY, NO_COMMAND, 100.0 * part, f"acceleration by external[{k}]")


def cables_pull(subject: BackendSubject) -> None:
    """Each command pulls the platform along its own cable, at the anchor of this cable."""
    for i, part in enumerate(np.eye(8)):
        _accelerates(subject, NO_GRAVITY, 100.0 * part, NO_WRENCH, f"acceleration by cable {i + 1}")


def loads_are_not_clamped(subject: BackendSubject) -> None:
    """The plant does not clip commands or wrenches, even if they are far outside the limits of the cables."""
    for size in LOADS:
        pull, push = size * np.linspace(0.5, 1.0, 8), size * np.array([0.3, -0.5, 0.7, 0.2, 0.1, -0.4])
        _accelerates(subject, NO_GRAVITY, pull, NO_WRENCH, f"acceleration by commands of {size:g} N", least=0.0)
        _accelerates(subject, NO_GRAVITY, NO_COMMAND, push, f"acceleration by a wrench of {size:g} N", least=0.0)


def _accelerates(
    subject: BackendSubject, gravity: Array, command: Array, external: Array, what: str, least: float = 1.0
) -> None:
    """Compare one short step from rest with the equations of motion; `least` is the smallest reference magnitude."""
    start = samples.state(np.random.default_rng(12), speed=0.0)
    backend = subject.make(start, gravity=gravity, step=SHORT)
    backend.command[:], backend.external[:] = command, external
    backend.step(1)
    wanted = samples.acceleration(samples.free(), start, gravity, command, external)
    expect_close(backend.state[7:] / SHORT, wanted, ONE_STEP * max(least, float(np.abs(wanted).max())), what)
    subject.close(backend)


def wrench_ends(subject: BackendSubject) -> None:
    """After command and external wrench are set to zero, their earlier values have no effect."""
    backend = subject.make(samples.state(np.random.default_rng(13), tilt=0.3))
    backend.command[:], backend.external[:] = np.linspace(100.0, 400.0, 8), [900.0, 500.0, 700.0, 50.0, 40.0, 60.0]
    backend.step(3)
    backend.command[:], backend.external[:] = 0.0, 0.0
    here = backend.state.copy()
    backend.step(1)
    wanted = samples.travel(samples.free(), here, GRAVITY, NO_COMMAND, NO_WRENCH, 1e-3, 1e-3)
    expect_close(samples.distance(backend.state, wanted), 0.0, STALE, "state one step after command and wrench ended")


def coasting_keeps_velocity(subject: BackendSubject) -> None:
    """A free body keeps its velocity: the engine does not damp the motion.

    The kit tests 3 m/s and 1e-4 m/s.
    """
    for speed in (3.0, 1e-4):
        start = samples.state(np.random.default_rng(14), speed=speed)
        backend = subject.make(start, samples.ball(), NO_GRAVITY, 1e-2)
        backend.step(1000)
        expect_close(backend.state[7:] / speed, start[7:] / speed, 1e-9, f"share of {speed:g} m/s after 10 s")
        expect_close(backend.state[:3], start[:3] + 10.0 * start[7:10], 1e-9 * max(1.0, 10.0 * speed), "position, m")


def coasts_however_slowly(subject: BackendSubject) -> None:
    """A free body keeps even a very low velocity: the engine does not set it to zero.

    The kit tests 1e-5, 1e-7 and 1e-9, in m/s and in rad/s.
    """
    for speed in SLOW:
        for part, what in ((slice(7, 10), "m/s"), (slice(10, 13), "rad/s")):
            start = samples.state(np.random.default_rng(14), speed=0.0)
            start[part] = speed * np.array([0.6, 0.0, -0.8])
            backend = subject.make(start, samples.ball(), NO_GRAVITY, 1e-2)
            backend.step(1000)
            expect_close(
                backend.state[part] / speed, start[part] / speed, 1e-6, f"share of {speed:g} {what} after 10 s"
            )
            subject.close(backend)


def gravity_pulls_under_any_load(subject: BackendSubject) -> None:
    """Gravity adds the same acceleration, no matter how large commands and external wrench are."""
    for size in LOADS:
        pull, push = size * np.linspace(0.5, 1.0, 8), size * np.array([0.3, -0.5, 0.7, 0.2, 0.1, -0.4])
        for command, external, what in ((pull, NO_WRENCH, "commands"), (NO_COMMAND, push, "a wrench")):
            found = [_after_a_step(subject, gravity, command, external) for gravity in (GRAVITY, NO_GRAVITY)]
            expect_close(
                (found[0] - found[1])[:3], GRAVITY, 1e-5 * 9.81, f"acceleration by gravity beside {what} of {size:g} N"
            )


def _after_a_step(subject: BackendSubject, gravity: Array, command: Array, external: Array) -> Array:
    """Return the linear and angular acceleration (6,) of one short step from rest."""
    backend = subject.make(samples.state(np.random.default_rng(12), speed=0.0), gravity=gravity, step=SHORT)
    backend.command[:], backend.external[:] = command, external
    backend.step(1)
    found = backend.state[7:] / SHORT
    subject.close(backend)
    return found


def long_fall(subject: BackendSubject) -> None:
    """During a fall of 30 s, the speed is g times the time.

    If the backend declares `speed_max`, the fall is shorter, and its speed stays below this value.
    """
    limit = float(subject.properties.get("speed_max", math.inf))
    h = 1e-2
    steps = int(min(3000.0, 0.9 * limit / (9.81 * h)))
    start = samples.state(np.random.default_rng(15), speed=0.0)
    backend = subject.make(start, samples.ball(), step=h)
    backend.step(steps)
    t = steps * h
    expect_close(backend.state[9] / (9.81 * t), -1.0, 1e-9, f"share of the speed after {t:g} s")
    expect_close(backend.state[2] - start[2], -4.905 * t * t, 0.51 * 9.81 * t * h, "height lost, m")


def tumbling_keeps_energy_and_momentum(subject: BackendSubject) -> None:
    """A platform that rotates freely keeps its energy and momentum.

    In 10 s, the energy changes by at most 0.5 %, and the angular momentum by at most 0.3 %.
    """
    start, robot = samples.state(np.random.default_rng(16)), samples.free()
    start[7:] = [0.3, -0.2, 0.1, 0.2, 3.0, 0.1]
    backend = subject.make(start, gravity=NO_GRAVITY)
    backend.step(10_000)
    (energy, momentum, spin), (energy_0, momentum_0, spin_0) = (_invariants(robot, s) for s in (backend.state, start))
    expect_close(energy / energy_0, 1.0, 5e-3, "kinetic energy, share")
    expect_close(momentum, momentum_0, 1e-9, "momentum, kg m/s")
    expect_close(spin, spin_0, 3e-3 * float(np.linalg.norm(spin_0)), "angular momentum, world axes, kg m^2/s")
    expect_close(np.linalg.norm(backend.state[3:7]), 1.0, 1e-9, "norm of the quaternion")


def _invariants(robot: Robot, state: Array) -> tuple[float, Array, Array]:
    """Return the kinetic energy, momentum and angular momentum about the centre of mass."""
    R, platform = rotations.matrix(state[3:7]), robot.platform
    v = state[7:10] + np.cross(state[10:], R @ platform.center_of_mass)
    spin = R @ platform.inertia @ R.T @ state[10:]
    return 0.5 * platform.mass * float(v @ v) + 0.5 * float(spin @ state[10:]), platform.mass * v, spin


def hovers_in_balance(subject: BackendSubject) -> None:
    """If an external wrench balances the weight, the platform remains at rest for two seconds."""
    start = samples.state(np.random.default_rng(17), speed=0.0)
    backend = subject.make(start)
    backend.external[:] = dynamics.required_wrench(samples.free(), start, GRAVITY)
    backend.step(2000)
    expect_close(samples.distance(backend.state, start), 0.0, 1e-9, "drift in 2 s")


def nan_shows(subject: BackendSubject) -> None:
    """If a command or the external wrench is NaN or infinite, the next `state` is invalid, or an error is raised.

    An invalid state contains NaN, infinity or a huge speed.
    """
    for value in (math.nan, math.inf):
        for k in range(6):
            _shows(subject, NO_COMMAND, np.where(np.arange(6) == k, value, 0.0))
        _shows(subject, np.array([50.0] * 7 + [value]), NO_WRENCH)


def huge_wrench_shows(subject: BackendSubject) -> None:
    """A wrench of 1e30 causes a huge speed or an error. The plant does not limit or reset the speed."""
    for part in np.eye(6):
        _shows(subject, NO_COMMAND, 1e30 * part)


def _shows(subject: BackendSubject, command: Array, external: Array) -> None:
    """Fail unless the state after one step with this load is obviously invalid."""
    backend = subject.make(samples.state(np.random.default_rng(18), tilt=0.3))
    backend.step(20)
    backend.command[:], backend.external[:] = command, external
    try:
        backend.step(1)
    except CdprError:
        return
    speed, spin = np.linalg.norm(backend.state[7:10]), np.linalg.norm(backend.state[10:])
    if np.isfinite(backend.state).all() and speed < SPEED_MAX and spin < ANGULAR_SPEED_MAX:
        raise Failed(f"command {command.tolist()}, external {external.tolist()}: the next state looks sound")
    subject.close(backend)


def order_is_as_declared(subject: BackendSubject) -> str:
    """The error of the state is proportional to step^p, where p is the declared `order`.

    The commands are constant. Skipped if the backend declares no `order`.
    """
    order = subject.properties.get("order")
    needs(order is not None, "it declares no order")
    rng = np.random.default_rng(5)
    start, command, external = samples.state(rng, tilt=0.3), rng.uniform(20.0, 120.0, 8), 30.0 * rng.normal(size=6)

    def end(step: float) -> Array:
        backend = subject.make(start, step=step)
        backend.command[:], backend.external[:] = command, external
        backend.step(round(0.4 / step))
        return backend.state

    return expect_order(float(order or 0), end, _truth(start.tobytes(), command.tobytes(), external.tobytes()))


@lru_cache
def _truth(start: bytes, command: bytes, external: bytes) -> Array:
    state, pull, push = (np.frombuffer(part) for part in (start, command, external))
    return samples.travel(samples.free(), state, GRAVITY, pull, push, 0.4, 2e-3)


def expect_order(order: float, end: Callable[[float], Array], truth: Array) -> str:
    """Fail unless the distance of `end(step)` from the reference falls with `order`; return the measured order."""
    steps = np.array([20e-3, 10e-3, 5e-3] if order > 1.5 else [4e-3, 2e-3, 1e-3])
    errors = [samples.distance(end(step), truth) for step in steps]
    measured = float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
    expect(abs(measured - order) <= 0.3, f"declared order {order:g}, measured {measured:.2f}")
    return f"measured {measured:.2f}"


CHECKS = [
    Check(function)
    for function in (
        state_round_trip,
        state_is_current,
        gravity_pulls,
        gravity_pulls_under_any_load,
        external_wrench_acts_on_the_origin,
        cables_pull,
        loads_are_not_clamped,
        wrench_ends,
        coasting_keeps_velocity,
        coasts_however_slowly,
        long_fall,
        tumbling_keeps_energy_and_momentum,
        hovers_in_balance,
        nan_shows,
        huge_wrench_shows,
        order_is_as_declared,
    )
]
