"""Checks of a backend that simulates the environment of its platform (property `surroundings`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cdpr.model import Box, Robot, Sphere
from cdpr.model.robot import Array, frozen_array
from cdpr.model.shapes import Obstacle
from cdpr.plugins import Environment
from cdpr.testing import samples
from cdpr.testing.check import Check, expect, expect_close, needs
from cdpr.testing.subjects import BackendSubject

RADIUS = 0.25  # m, of the platform
FALL = 0.2  # m, to the obstacle
DEPTH = 0.05  # m, largest penetration
STEPS = 600


def obstacles_stop_the_platform(subject: BackendSubject) -> None:
    """A platform that falls onto an obstacle does not pass through it.

    After `reset`, it falls again and stops there again. Skipped if the backend does not declare `obstacles`.
    """
    _needs_obstacles(subject)
    start = np.zeros(13)
    start[2:4] = RADIUS + FALL, 1.0
    backend = subject.make(start, _sphere(), environment=_table(0.0))
    for _ in range(2):
        backend.step(STEPS)
        height = float(backend.state[2])
        expect(height > RADIUS - DEPTH, f"its centre is at {height:.3g} m, {RADIUS - height:.3g} m too deep")
        expect(height < start[2] - FALL / 2, f"its centre is at {height:.3g} m: it does not fall")
        backend.reset(start)


def distant_obstacles_have_no_effect(subject: BackendSubject) -> None:
    """An obstacle that the platform does not touch has no effect on the motion.

    Skipped if the backend does not declare `obstacles`.
    """
    _needs_obstacles(subject)
    start = samples.state(np.random.default_rng(80), tilt=0.3)

    def end(environment: Environment | None) -> Array:
        backend = subject.make(start, _sphere(), environment=environment)
        backend.command[:] = np.linspace(40.0, 130.0, len(backend.command))
        backend.step(STEPS)
        return backend.state.copy()

    expect_close(end(_table(-50.0)), end(None), 1e-12, "state with an obstacle 50 m below")


def _needs_obstacles(subject: BackendSubject) -> None:
    declared = subject.properties.get("surroundings", ())
    needs("obstacles" in declared, "it does not declare obstacles in surroundings")


def _sphere() -> Robot:
    robot = samples.ball()
    return replace(robot, platform=replace(robot.platform, shape=Sphere(RADIUS)))


def _table(height: float) -> Environment:
    """Return a wide box, 0.2 m thick, with its top at this height, m."""
    middle, upright = frozen_array([0.0, 0.0, height - 0.1]), frozen_array([1.0, 0.0, 0.0, 0.0])
    return Environment(obstacles=(Obstacle("table", Box((20.0, 20.0, 0.2)), middle, upright),))


CHECKS = [Check(function) for function in (obstacles_stop_the_platform, distant_obstacles_have_no_effect)]
