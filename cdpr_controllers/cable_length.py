"""Control of each cable's length and rate, as the drives of a cable robot do it; no pose is measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cdpr.cables.lines import lines
from cdpr.cables.tables import line_table
from cdpr.errors import CdprError
from cdpr.mechanics.forward_kinematics import fit, scales, work_size
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr_controllers.holding import Holding


class CableLength(SnapshotOfArrays, Controller):
    """A PID law per cable about tensions that hold the platform up.

    command = f + kp e + z + kd e' with e = l - l_d: a cable that is too long pulls more. Desired lengths and rates
    come from the desired pose and twist by inverse kinematics; the measured ones are all that is taken from the state.
    f balances the weight (see `Holding`) at the pose that forward kinematics finds from the measured lengths, started
    from the previous one, or from the desired pose at first and after a fit that failed. Without forward kinematics it
    is the desired pose.

    z is the integral of ki e over time, a sum over control steps, the present one included. Against wind-up it stays
    within +-integral_limit, and does not grow while its cable is at the limit of tension that it pushes against. More
    lengths than degrees of freedom cannot all be right where the geometry is wrong: the integrals then push against
    each other, up to their limits.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        n, m = robot.n, robot.m
        if options.forward_kinematics and m < n:
            raise CdprError(
                f"cable_length: {m} lengths do not determine {n} degrees of freedom; set forward_kinematics: false"
            )
        self._gains = np.zeros((4, m))
        self.change(options)
        limits = np.array([robot.tension_min, robot.tension_max])
        self._pose = np.zeros(7)
        self._tracking = np.zeros(1, dtype=bool)  # whether the pose is one that was found
        self._integral, self._command = np.zeros(m), np.zeros(m)
        self._measured, self._desired = np.zeros((2, m)), np.zeros((2, m))
        self._measure = self._lengths_and_rates(self._measured)
        self._want = self._lengths_and_rates(self._desired)
        self._fit = None
        if options.forward_kinematics:
            work = np.zeros(work_size(n, m))
            self._fit = partial(
                fit, lines(robot), *scales(robot), self._measured[0], self._pose, np.zeros((n, n)), work
            )
        self._holding = Holding(robot, gravity, options.pretension)
        self.arrays = (self._pose, self._tracking, self._integral, self._holding.tension)
        self._law = bind(
            "cable_length",
            gains=self._gains,
            limits=limits,
            measured=self._measured,
            desired=self._desired,
            feed=self._holding.tension,
            integral=self._integral,
            command=self._command,
        )

    def _lengths_and_rates(self, out: Array) -> Callable[[Array], None]:
        """Return a function that writes lengths (m) and rates (m/s) at a state into `out` (2, m)."""
        state, matrix = np.zeros(13), np.zeros((6, self.robot.m))
        call = bind("geometry", lines=line_table(self.robot), state=state, matrix=matrix, length=out[0], rate=out[1])

        def measure(at: Array) -> None:
            state[:] = at[:13]
            call()

        return measure

    def change(self, options: Any) -> None:
        """Take other gains and limits of the integrals; these stay, within their limits from the next step on."""
        m = self.robot.m
        given = {"kp": options.kp, "kd": options.kd, "ki": options.ki, "integral_limit": options.integral_limit}
        for name, value in given.items():
            if np.ndim(value) and len(value) != m:
                raise CdprError(f"cable_length: {name} has {len(value)} values, the robot {m} cables")
        self._gains[:] = [np.broadcast_to(value, m) for value in given.values()]
        self._gains[2] *= self.control_step

    def sense(self, cables: Array) -> None:
        """Measure at the cables what they are, whatever the robot is believed to be."""

        def measure(state: Array) -> None:
            self._measured[:] = cables

        self._measure = measure

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the commands (m,)."""
        self._measure(state)
        self._want(desired)
        if not self._tracking[0]:
            self._pose[:] = desired[:7]
        if self._fit is not None:
            self._tracking[0] = self._fit()[0] > 0
            if not self._tracking[0]:
                self._pose[:] = desired[:7]
        self._holding.update(self._pose)
        self._law()
        out[:] = self._command

    def reset(self) -> None:
        """Clear the integrals and the estimate of the pose."""
        self._integral[:] = 0.0
        self._tracking[0] = False
