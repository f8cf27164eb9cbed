"""Checks of a backend with a guided platform: free along x and z and about y, or on a ball joint."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.testing import samples
from cdpr.testing.backend_physics import ONE_STEP, SHORT, expect_order
from cdpr.testing.check import Check, expect_close, needs
from cdpr.testing.samples import GRAVITY, NO_GRAVITY
from cdpr.testing.subjects import BackendSubject


def guided_state_round_trip(subject: BackendSubject) -> None:
    """After `reset(start)` of a guided platform, `state` equals `start`."""
    rng = np.random.default_rng(30)
    backend = subject.guided(samples.planar_state(rng))
    for _ in range(50):
        given = samples.planar_state(rng, speed=3.0)
        backend.reset(given)
        expect_close(samples.distance(backend.state, given), 0.0, 1e-11, "state after reset")


def guided_wrench_accelerates(subject: BackendSubject) -> None:
    """The acceleration of a guided platform agrees with its equations of motion.

    The kit tests gravity, each cable, and each component of the external wrench.
    """
    _accelerates(subject, samples.planar(), samples.planar_state(np.random.default_rng(31), speed=0.0))


def _accelerates(subject: BackendSubject, robot: Robot, start: Array) -> None:
    none = np.zeros(robot.m)
    loads = [(GRAVITY, none, np.zeros(6), "gravity")]
    loads += [(NO_GRAVITY, 100.0 * part, np.zeros(6), f"cable {i + 1}") for i, part in enumerate(np.eye(robot.m))]
    loads += [(NO_GRAVITY, none, 100.0 * part, f"external[{k}]") for k, part in enumerate(np.eye(6))]
    for gravity, command, external, what in loads:
        backend = subject.guided(start, gravity, SHORT, robot=robot)
        backend.command[:], backend.external[:] = command, external
        backend.step(1)
        wanted = samples.acceleration(robot, start, gravity, command, external)
        allowed = ONE_STEP * max(1.0, float(np.abs(wanted).max()))
        expect_close(backend.state[7:] / SHORT, wanted, allowed, f"acceleration by {what}")
        subject.close(backend)


def held_directions_stay(subject: BackendSubject) -> None:
    """A guided platform does not move in the directions that its guide blocks, under any load."""
    start = samples.planar_state(np.random.default_rng(32))
    backend = subject.guided(start)
    backend.command[:] = np.linspace(50.0, 200.0, 4)
    backend.external[:] = [10.0, 5000.0, 300.0, 800.0, 2.0, 900.0]
    for _ in range(10):
        backend.step(30)
        expect_close(backend.state[[1, 8]], 0.0, 1e-12, "y and its rate")
        expect_close(backend.state[[4, 6, 10, 12]], 0.0, 1e-12, "attitude and angular velocity about x and z")


def guided_order_is_as_declared(subject: BackendSubject) -> str:
    """The error of a guided platform's state is proportional to step^p, where p is the declared `order`."""
    return _order(subject, samples.planar(), _start(), COMMAND, _truth())


def _order(subject: BackendSubject, robot: Robot, start: Array, command: Array, truth: Array) -> str:
    order = subject.properties.get("order")
    needs(order is not None, "it declares no order")

    def end(step: float) -> Array:
        backend = subject.guided(start, step=step, robot=robot)
        backend.command[:], backend.external[:] = command, EXTERNAL
        backend.step(round(0.4 / step))
        return backend.state

    return expect_order(float(order or 0), end, truth)


def spherical_state_round_trip(subject: BackendSubject) -> None:
    """After `reset(start)` of a platform on a ball joint, `state` equals `start`, in any attitude."""
    rng = np.random.default_rng(34)
    backend = subject.guided(samples.spherical_state(rng), robot=samples.spherical())
    for _ in range(50):
        given = samples.spherical_state(rng, speed=3.0)
        backend.reset(given)
        expect_close(samples.distance(backend.state, given), 0.0, 1e-11, "state after reset")


def spherical_wrench_accelerates(subject: BackendSubject) -> None:
    """The acceleration of a platform on a ball joint agrees with its equations of motion.

    The kit tests gravity, each cable, and each component of the external wrench.
    """
    _accelerates(subject, samples.spherical(), samples.spherical_state(np.random.default_rng(35), speed=0.0))


def spherical_origin_stays(subject: BackendSubject) -> None:
    """A platform on a ball joint rotates only: its origin does not move, under any load."""
    start = samples.spherical_state(np.random.default_rng(36))
    backend = subject.guided(start, robot=samples.spherical())
    backend.command[:] = 100.0
    backend.external[:] = [10.0, 5000.0, 300.0, 8.0, 2.0, 9.0]
    for _ in range(10):
        backend.step(30)
        expect_close(backend.state[:3], start[:3], 1e-12, "position")
        expect_close(backend.state[7:10], 0.0, 1e-12, "velocity")


def spherical_order_is_as_declared(subject: BackendSubject) -> str:
    """The error of the state on a ball joint is proportional to step^p, where p is the declared `order`."""
    return _order(subject, samples.spherical(), _spherical_start(), BALL_COMMAND, _spherical_truth())


COMMAND = np.array([60.0, 90.0, 320.0, 280.0])
BALL_COMMAND = np.linspace(60.0, 200.0, 8)
EXTERNAL = np.array([20.0, 50.0, -30.0, 40.0, 5.0, -60.0])


def _start() -> Array:
    return samples.planar_state(np.random.default_rng(33))


@lru_cache
def _truth() -> Array:
    return samples.travel(samples.planar(), _start(), GRAVITY, COMMAND, EXTERNAL, 0.4, 2e-3)


def _spherical_start() -> Array:
    return samples.spherical_state(np.random.default_rng(37))


@lru_cache
def _spherical_truth() -> Array:
    return samples.travel(samples.spherical(), _spherical_start(), GRAVITY, BALL_COMMAND, EXTERNAL, 0.4, 2e-3)


CHECKS = [
    Check(function)
    for function in (
        guided_state_round_trip,
        guided_wrench_accelerates,
        held_directions_stay,
        guided_order_is_as_declared,
        spherical_state_round_trip,
        spherical_wrench_accelerates,
        spherical_origin_stays,
        spherical_order_is_as_declared,
    )
]
