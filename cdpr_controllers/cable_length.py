"""Control of each cable's length and rate, as the drives of a cable robot do it; no pose is measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cdpr.cables.lines import lines
from cdpr.errors import CdprError
from cdpr.mechanics.forward_kinematics import fit, scales, work_size
from cdpr.mechanics.geometry import cable_geometry
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.tension.checks import LIMIT_TOLERANCE
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
        self._integral = np.zeros(m)
        measured, wanted, W = np.zeros((2, m)), np.zeros((2, m)), np.zeros((6, m))
        self._measured = measured
        self._measure: Callable[[Array], None] = partial(lengths_and_rates, lines(robot), W, measured)
        self._want = partial(lengths_and_rates, lines(robot), W, wanted)
        self._fit = None
        if options.forward_kinematics:
            work = np.zeros(work_size(n, m))
            self._fit = partial(fit, lines(robot), *scales(robot), measured[0], self._pose, np.zeros((n, n)), work)
        self._holding = Holding(robot, gravity, options.pretension)
        self.arrays = (self._pose, self._tracking, self._integral, self._holding.tension)
        self._law = partial(law, self._gains, limits, measured, wanted, self._holding.tension, self._integral)

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
        self._law(out)

    def reset(self) -> None:
        """Clear the integrals and the estimate of the pose."""
        self._integral[:] = 0.0
        self._tracking[0] = False


@kernel
def lengths_and_rates(lines: Array, W: Array, out: Array, state: Array) -> None:
    """Write lengths (m) and rates (m/s) at `state` into `out` (2, m); W (6, m) is work space."""
    cable_geometry(lines, state, W, out[0], out[1])


@kernel
def law(
    gains: Array, limits: Array, measured: Array, wanted: Array, feed: Array, integral: Array, command: Array
) -> None:
    """Write the commands (m,) and advance the integrals (m,).

    `gains` (4, m): kp, kd, ki times the control step, limit of the integral; `limits` (2, m) of the tension;
    `measured` and `wanted` (2, m) are lengths and rates, `feed` (m,) the tensions that hold the platform up.
    """
    for i in range(command.shape[0]):
        e = measured[0, i] - wanted[0, i]
        change = gains[2, i] * e
        z = min(max(integral[i] + change, -gains[3, i]), gains[3, i])
        t = feed[i] + gains[0, i] * e + gains[1, i] * (measured[1, i] - wanted[1, i])
        pushes = (t + z > limits[1, i] - LIMIT_TOLERANCE and change > 0.0) or (
            t + z < limits[0, i] + LIMIT_TOLERANCE and change < 0.0
        )
        if not pushes or integral[i] * change < 0.0:
            integral[i] = z
        command[i] = t + integral[i]
