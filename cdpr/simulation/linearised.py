"""Slowest mode of a sampled closed loop, linearised numerically at a pose of rest."""

from __future__ import annotations

import math
from contextlib import ExitStack

import numpy as np

from cdpr.log.recorder import BLOCK
from cdpr.mechanics.body_frame import platform_state
from cdpr.mechanics.winches import Winches
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.scenario import Scenario
from cdpr.scenario.motions.hold import Hold
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

# Steps of the central differences. The error of an eigenvalue is then below 1e-8 in one control step: the loop is
# smooth over such steps, and round-off is smaller by seven orders.
LENGTH = 1e-7  # of the frame's extent
ANGLE = 1e-7  # rad
TENSION = 1e-4  # of the highest tension limit
OWN = 1e-6  # of an own state of a winch, or of 1 if that is larger


def decay_rate(scenario: Scenario, pose: Array) -> float:
    """Return the decay rate (1/s) of the slowest mode at a pose; negative for a growing mode.

    Central differences of the simulation give the derivative of one control step: a map of platform, winches and
    commands. A mode with the eigenvalue z grows if |z| > 1.

    Args:
        scenario: scenario with cables on winches, on a backend with the attribute `winches`.
        pose: (7,) position and attitude at rest, m; w, x, y, z.

    Raises:
        SimulationStopped: if the loop stops at this pose.
    """
    rest = {"position": pose[:3].tolist(), "orientation": {"quaternion": pose[3:].tolist()}}
    held = scenario.with_changes({"trajectory": {"type": Hold().type}, "initial": rest})
    with ExitStack() as opened:
        parts = build(held)
        opened.callback(parts.controller.close)
        opened.callback(parts.backend.close)
        loop = Loop(parts)
        opened.callback(loop.close)
        loop.warm_up(held.initial.state())
        largest = float(np.abs(np.linalg.eigvals(_Step(loop, held).matrix())).max())
    return -math.log(max(largest, np.finfo(float).tiny)) / held.simulation.control_step


class _Step:
    """One control step as a function of platform, winches and commands."""

    def __init__(self, loop: Loop, scenario: Scenario) -> None:
        backend = loop.parts.backend
        winches = getattr(backend, "winches", None)
        assert isinstance(backend, Backend)
        assert isinstance(winches, Winches)
        self._loop, self._backend, self._winches = loop, backend, winches
        loop.begin(np.zeros((BLOCK, len(loop.row))), BLOCK)
        loop.decide()
        loop.advance()
        self._start = loop.snapshot()
        loop.decide()
        self._attitude = winches.body[3:7].copy()
        free, stretching, turning = np.flatnonzero(winches.free), winches.stretching, winches.per_turn
        unwound = winches.places[stretching]
        robot, step = scenario.robot, scenario.simulation.control_step
        m = robot.m
        length = LENGTH * float(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0)))
        poses = np.where(np.arange(6) < 3, length, ANGLE)
        drums = length / np.where(turning > 0.0, turning, 1.0) / step
        states = OWN * np.maximum(np.abs(winches.state), 1.0)
        states[unwound], states[unwound + 1] = length, drums[stretching]
        self._sizes = np.concatenate([poses, poses / step, states, np.full(m, TENSION * robot.tension_max.max())])
        own = np.setdiff1d(np.arange(len(states)), [unwound, unwound + 1])
        winch = 12 + np.concatenate([unwound, unwound + 1, own])
        self._moving = np.concatenate([free, 6 + free, winch, 12 + len(states) + np.arange(m)])

    def matrix(self) -> Array:
        """Return the derivative of the step, in units of the differences."""
        sizes = self._sizes[self._moving]
        columns = [self._after(i, size) - self._after(i, -size) for i, size in zip(self._moving, sizes, strict=True)]
        return np.asarray(np.array(columns).T[self._moving] / (2.0 * sizes[:, None]))

    def _after(self, i: int, size: float) -> Array:
        """Return platform, winches and commands one step after a change of coordinate i."""
        self._loop.restore(self._start)
        self._loop.decide()
        self._change(i, size)
        self._loop.advance()
        self._loop.decide()
        body = self._winches.body
        turned = rotations.rotation_vector(rotations.multiply(body[3:7], rotations.conjugate(self._attitude)))
        return np.concatenate([body[:3], turned, body[7:], self._winches.state, self._loop.tension])

    def _change(self, i: int, size: float) -> None:
        body, winch = self._winches.body, self._winches.state
        if i < 3:
            body[i] += size
        elif i < 6:
            turn = rotations.from_axis_angle(np.eye(3)[i - 3], size)
            body[3:7] = rotations.multiply(turn, body[3:7])
        elif i < 12:
            body[i + 1] += size
        elif i < 12 + len(winch):
            winch[i - 12] += size
        else:
            self._loop.tension[i - 12 - len(winch)] += size
        self._backend.state[:] = platform_state(self._winches.offset, body)
