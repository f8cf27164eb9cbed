"""Winches of a plant in another process: their commands, and what the plant measures."""

from __future__ import annotations

import numpy as np

from cdpr.cables.tables import line_table, reached_by_rate
from cdpr.mechanics.cable_geometry import cable_geometry
from cdpr.model import Robot
from cdpr.model.robot import Array


class MeasuredWinches:
    """Tensions and unwound lengths that a plant measures.

    Args:
        robot: robot.
        state: (13,), state of the platform, live.

    Attributes:
        tension: (m,), N, as answered last.
        highest: (m,), N, largest magnitude of each tension so far.
        work: work of the tensions on the platform, J: those at the end of each step times the way in the step.
    """

    def __init__(self, robot: Robot, state: Array) -> None:
        m = robot.m
        self.tension, self.highest, self.work = np.zeros(m), np.zeros(m), 0.0
        self._state, self._lines, self._length = state, line_table(robot), np.zeros(m)
        self._unwound, self._before, self._rate = np.zeros(m), np.zeros(m), np.zeros(m)
        self._by_rate = reached_by_rate(robot)

    def take(self, answer: Array) -> None:
        """Take the tensions (m,), N, and the unwound lengths (m,), m, of an answer."""
        m = len(self.tension)
        self._before[:] = self._unwound
        self.tension[:], self._unwound[:] = answer[:m], answer[m:]
        np.maximum(self.highest, np.abs(self.tension), out=self.highest)

    def begin(self) -> None:
        """Begin at the present state."""
        self.work, self._rate[:] = 0.0, 0.0
        self.highest[:] = np.abs(self.tension)
        self._length[:] = self._lengths()

    def moved(self, duration: float) -> None:
        """Add the work of a step of this duration, s."""
        length = self._lengths()
        self.work += float(self.tension @ (self._length - length))
        self._length[:] = length
        self._rate[:] = (self._unwound - self._before) / duration

    def commands(self, command: Array, duration: float) -> Array:
        """Return what the winches take during a step: of ideal drives the lengths at its end."""
        return np.where(self._by_rate, self._unwound + command * duration, command)

    def read(self, unwound: Array, unwinding: Array, torque: Array) -> None:
        """Write the unwound lengths and their mean rates in the last step; no torques."""
        unwound[:], unwinding[:], torque[:] = self._unwound, self._rate, np.nan

    def _lengths(self) -> Array:
        return cable_geometry(self._lines, self._state)[1]
