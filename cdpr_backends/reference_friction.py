"""Reference integrator for free platforms whose cables lose tension on their exits; winches hold tensions."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.backend import Operations
from cdpr_backends.reference import ReferenceBackend


class FrictionReference(ReferenceBackend):
    """Scheme of `ReferenceBackend`, with the work of the cables as a further variable.

    A command is the tension at the winch. Friction changes it into that at the platform, at every stage.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.highest, self._work = np.zeros(robot.m), np.zeros(1)
        self._last = np.full(2 * robot.m + 20, np.nan)  # pull at the last reading of the tensions
        self.bind_steps("friction_step", **self._given, cable_work=self._work, highest=self.highest, last=self._last)
        self.arrays = (*self.arrays, self.highest, self._work)

    def renew(self, robot: Robot) -> bool:
        """Move another platform from the next reset on."""
        self._last[:] = np.nan
        return super().renew(robot)

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,)."""
        super().reset(state)
        self.highest[:] = self._work[:] = 0.0

    def read_tension(self, tension: Array) -> None:
        """Write the tensions (m,)."""
        self._reading(tension)()

    def cable_work(self) -> float:
        """Return the work of the cables on the platform [J]."""
        return float(self._work[0])

    def readings(self, tension: Array, work: Array) -> tuple[Operations, Operations] | None:
        """Return the operations that write tensions and work."""
        return [self._reading(tension)], [bind("copy", source=self._work, target=work)]

    def winch_tensions(self, tension: Array) -> Operations:
        """Return the operation that writes the tensions at the winches, the commands."""
        return [bind("copy", source=self.command, target=tension)]

    def _reading(self, tension: Array) -> Any:
        given = {"lines": self.frame.line_table, "body": self._body, "command": self.command, "last": self._last}
        return bind("exit_tensions", **given, tension=tension)
