"""Compiled control laws for calls with changing arrays, and base classes of those that compute a wrench."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.plugins.controller import Tunable


class Law:
    """Compiled law, bound once to its own arrays.

    Args:
        bound: function that binds the law to a state (13,), a desired state (19,) and an output, as
            `Controller.compiled`.
        width: width of the output, 6 for a wrench, m for commands.
    """

    def __init__(self, bound: Callable[[Array, Array, Array], Callable[[], object]], width: int) -> None:
        self._state, self._desired, self._out = np.zeros(13), np.zeros(19), np.zeros(width)
        self._call = bound(self._state, self._desired, self._out)

    def __call__(self, state: Array, desired: Array, out: Array) -> None:
        """Write the output for a state (13,) and a desired state (19,)."""
        self._state[:] = state
        self._desired[:] = desired
        self._call()
        out[:] = self._out


class WrenchLaw(SnapshotOfArrays, Controller):
    """Controller with a compiled law that computes a wrench from gains, and the mass properties of the robot.

    Args:
        more: further arrays of the law.

    Attributes:
        operation: name of the law in the kernel library.
        gains_shape: shape of the law's gains, which `change` writes.
    """

    operation: ClassVar[str]
    gains_shape: ClassVar[tuple[int, ...]]
    arrays: tuple[Array, ...] = ()

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any, **more: Array) -> None:
        super().__init__(robot, gravity, control_step, options)
        body = {"inertial": robot.inertial.copy(), "gravity": np.array(gravity, dtype=np.float64)}
        self._given = {"gains": np.zeros(self.gains_shape), **body, **more}
        self.change(options)

    @cached_property
    def _law(self) -> Law:
        return Law(self.compiled, 6)

    def renew(self, robot: Robot) -> bool:
        """Use the mass properties of another platform."""
        self.robot = robot
        self._given["inertial"][:] = robot.inertial
        return True

    def control(self, time: float, state: Array, desired: Array, wrench: Array) -> None:
        """Write the wrench (6,)."""
        self._law(state, desired, wrench)

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law bound to these arrays."""
        return bind(self.operation, **self._given, state=state, desired=desired, wrench=out)

    def _give(self, **arrays: Array) -> None:
        """Replace arrays of the law."""
        self._given |= arrays
        vars(self).pop("_law", None)


class GainLaw(WrenchLaw):
    """Controller whose compiled law has proportional and damping gains."""

    gains_shape = (12,)

    def change(self, options: Any) -> None:
        """Set new gains."""
        self._given["gains"][:6], self._given["gains"][6:] = options.kp, options.kd

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains."""
        kp, kd = self._given["gains"][:6], self._given["gains"][6:]
        return {"kp": Tunable(kp, kp.copy()), "kd": Tunable(kd, kd.copy())}
