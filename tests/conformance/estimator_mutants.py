"""Deliberately broken estimators, each with the checks that must catch it."""

from __future__ import annotations

import numpy as np

from cdpr.mechanics.forward_kinematics import forward_kinematics
from cdpr.model import rotations
from cdpr.plugins import Column, Estimator, SnapshotOfArrays
from cdpr.sensing import Encoders, Pose, Twist

SENSORS = {"sensors": ("encoders",)}
MEASURED = {"sensors": ("pose", "twist")}


class Fitted(SnapshotOfArrays, Estimator):
    """Pose that fits the lengths, and velocities by differences of the poses: a correct estimator."""

    def __init__(self, robot, gravity, control_step, sensors, options):
        super().__init__(robot, gravity, control_step, sensors, options)
        self.encoders, self.last = self.first(Encoders), np.zeros(8)
        self.arrays = (self.last,)

    def connect(self, inputs):
        self.inputs = inputs

    def lengths(self):
        return self.encoders.measured[: self.robot.m]

    def estimate(self, time, out):
        if time == 0.0:
            out[:] = self.inputs.start
            self.last[:] = *self.inputs.start[:7], 0.0
        if not self.encoders.fresh[0]:
            return
        pose = forward_kinematics(self.robot, self.lengths(), self.last[:7]).pose
        taken = time - self.encoders.age[0]
        if taken > self.last[7]:
            step = taken - self.last[7]
            out[7:10] = (pose[:3] - self.last[:3]) / step
            out[10:] = rotations.between(self.last[None, 3:7], pose[None, 3:])[0] / step
        out[:7] = pose
        self.last[:] = *pose, taken


class Unwritten(Fitted):
    """It leaves the velocities as they are until the second measurement."""

    def estimate(self, time, out):
        given = out[7:].copy()
        super().estimate(time, out)
        if time == 0.0:
            out[7:] = given


class Unnormalised(Fitted):
    """Its quaternion grows."""

    def estimate(self, time, out):
        super().estimate(time, out)
        out[3:7] *= 1.01


class Presuming(Fitted):
    """It takes the true state to be the start without encoders."""

    def __init__(self, robot, gravity, control_step, sensors, options):
        if sensors:
            super().__init__(robot, gravity, control_step, sensors, options)
        self.arrays = ()


class Scaled(Fitted):
    """It mistakes the unit of the velocity."""

    def estimate(self, time, out):
        super().estimate(time, out)
        if self.encoders.fresh[0]:
            out[7:10] *= 1.5


class DeadReckoning(SnapshotOfArrays, Estimator):
    """It integrates the measured velocity and ignores the pose."""

    arrays = ()

    def __init__(self, robot, gravity, control_step, sensors, options):
        super().__init__(robot, gravity, control_step, sensors, options)
        self.pose, self.twist = self.first(Pose), self.first(Twist)

    def connect(self, inputs):
        self.inputs = inputs

    def estimate(self, time, out):
        if time == 0.0:
            out[:] = self.inputs.start
        out[7:] = self.twist.measured
        out[:3] += self.control_step * out[7:10]
        out[3:7] = rotations.multiply(
            rotations.from_axis_angle(_axis(out[10:]), self.control_step * _size(out)), out[3:7]
        )


def _size(out):
    return float(np.linalg.norm(out[10:]))


def _axis(turning):
    size = np.linalg.norm(turning)
    return turning / size if size else np.array([0.0, 0.0, 1.0])


class Extrapolating(Fitted):
    """It takes each measurement for a new one, and extends its velocities far."""

    def estimate(self, time, out):
        super().estimate(time, out)
        out[:3] += 0.2 * out[7:10] * (self.encoders.age[0] > 0.0)


class Counting(Fitted):
    """It ignores the lengths from the first command 0 of a cable on."""

    def estimate(self, time, out):
        if time > 0.0 and (self.inputs.tension == 0.0).any() and time > 0.01:
            out[:3] += 1e-3
            return
        super().estimate(time, out)


class Remembering(Fitted):
    """Its mean of all measurements survives a reset and a snapshot."""

    count = 0

    def estimate(self, time, out):
        self.count += 1
        super().estimate(time, out)
        out[0] += 1e-9 * self.count


class Twice(Fitted):
    """Its compiled operation does nothing."""

    def compiled(self, out):
        def nothing(time):
            out[:] = self.inputs.start
            return 0

        return [nothing]


class Lopsided(Fitted):
    """Its covariance is not symmetric."""

    def __init__(self, robot, gravity, control_step, sensors, options):
        super().__init__(robot, gravity, control_step, sensors, options)
        self.covariance = np.eye(12)
        self.covariance[0, 1] = 0.5


class Overconfident(Fitted):
    """It takes the noise to be a tenth of the true one."""

    def __init__(self, robot, gravity, control_step, sensors, options):
        super().__init__(robot, gravity, control_step, sensors, options)
        self.nis, self.nis_size = np.full(1, np.nan), np.zeros(1)

    def estimate(self, time, out):
        super().estimate(time, out)
        fresh = bool(self.encoders.fresh[0])
        self.nis_size[0] = self.robot.m if fresh else 0.0
        self.nis[0] = 100.0 * self.robot.m if fresh else np.nan


class Unlogged(Fitted):
    """It declares a column and does not write it."""

    columns = (Column("spread", 1, "m", "Spread"),)

    def log(self, columns):
        pass


MUTANTS = {
    Unwritten: (SENSORS, ["estimate_is_complete"]),
    Unnormalised: (SENSORS, ["estimate_is_complete"]),
    Presuming: (SENSORS, ["missing_sensors_are_reported"]),
    Scaled: (SENSORS, ["exact_measurements_are_followed"]),
    DeadReckoning: (MEASURED, ["wrong_start_is_forgotten"]),
    Extrapolating: (SENSORS, ["late_measurements_are_used"]),
    Counting: (SENSORS, ["cable_breaks"]),
    Remembering: (SENSORS, ["reset_forgets", "snapshot_restores"]),
    Twice: (SENSORS, ["compiled_operations_agree"]),
    Lopsided: ({**SENSORS, "covariance": True}, ["covariance_is_valid"]),
    Overconfident: ({**SENSORS, "innovation": True}, ["innovation_is_consistent"]),
    Unlogged: (SENSORS, ["columns_are_written"]),
}
