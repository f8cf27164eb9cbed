"""Spring and damper between the platform and its desired motion, and its weight."""

import ctypes
from importlib.util import find_spec

import numpy as np

from cdpr.native.foreign import Foreign
from cdpr.plugins import Controller, SnapshotOfArrays

LIBRARY = ctypes.CDLL(find_spec("cdpr_spring.kernel").origin)  # ctypes keeps the library loaded


class Spring(SnapshotOfArrays, Controller):
    """Controller with the same law in C, for compiled runs, and in Python."""

    arrays = ()  # no state to save in snapshots

    def __init__(self, robot, gravity, control_step, options):
        super().__init__(robot, gravity, control_step, options)
        mass, length = robot.platform.mass, robot.characteristic_length
        force = mass * np.array([options.kp, options.kd])
        self.gains = np.concatenate([force, length**2 * force])
        self.force = -mass * gravity
        self.center = np.array(robot.platform.center_of_mass, dtype=np.float64)

    def control(self, time, state, desired, out):
        """Write the wrench (6,)."""
        q, d, gains = state[3:7], desired[3:7], self.gains
        turned = cross(q[1:], self.center)
        lever = self.center + 2.0 * (q[0] * turned + cross(q[1:], turned))
        side = -2.0 if d[0] * q[0] + d[1] * q[1] + d[2] * q[2] + d[3] * q[3] < 0.0 else 2.0
        angle = side * (q[0] * d[1:] - d[0] * q[1:] - cross(d[1:], q[1:]))
        move, speed, spin = desired[:3] - state[:3], desired[7:10] - state[7:10], desired[10:13] - state[10:13]
        out[:3] = self.force + gains[0] * move + gains[1] * speed
        out[3:] = cross(lever, self.force) + gains[2] * angle + gains[3] * spin

    def compiled(self, state, desired, out):
        """Return the law in C with these arrays, in the order of its struct."""
        return Foreign(LIBRARY.spring, self.force, self.center, self.gains, state, desired, out)


def cross(a, b):
    """Return a x b."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
