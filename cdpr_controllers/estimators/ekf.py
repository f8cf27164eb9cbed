"""Extended Kalman filter of the platform's state, from any set of sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import TENSION, bends, chain_of, commands_of
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Estimator, EstimatorInputs, SensorModel, SnapshotOfArrays
from cdpr.sensing.sensor import Sensor
from cdpr_controllers.estimators.ekf_prediction import platform_arguments
from cdpr_controllers.estimators.ekf_tension_errors import numbers_of_errors
from cdpr_controllers.estimators.ekf_updates import USED, deviations, reason_to_ignore, sensor_tables

ERRORS = 12  # of a state: position, attitude, velocity, angular velocity
STATE_NUMBERS = 13 + ERRORS**2
MOST_LATE = 1000  # control steps, from a measurement to its arrival: each is repeated then
OVERDUE = 20  # missing measurements of load cells, after which the tensions may have changed by any amount


class Ekf(SnapshotOfArrays, Estimator):
    """Error-state Kalman filter on the nominal robot, forced by the tensions as sent.

    The error state is that of Sola (2017), "Quaternion kinematics for the error-state Kalman filter", section 5, but
    without biases, and with the angular velocity in world axes: position, attitude, velocity, angular velocity. The
    prediction is the rigid body with its centre of mass and inertia tensor under tensions, weight and a white wrench of
    unknown origin, by the explicit midpoint rule. Its derivatives contain the stiffness of the tensions. Winches
    contribute their inertia and friction; drums on cables that stretch are simulated, so that the tension lags behind
    its command. Blocked directions of a guided platform have no error.

    Measurements are used one scalar after the other, so no matrix is inverted. If the noise is that of the model, NIS
    and NEES follow the chi-square distribution: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking
    and Navigation (2001), section 5.4.

    - pose, twist, receiver, markers: all values, but no markers that are not seen.
    - encoders: the unwound lengths, with pulleys and with the stretch under the tensions. The rates are differences of
      the lengths, so they contain nothing new.
    - imu: the turn rate. The specific force is that of the model, except for the unknown wrench.
    - tension: in place of the commands, if winches take lengths or rates. Without load cells, such a platform is
      assumed to keep its velocity, with much noise, and encoders on cables that stretch are rejected. Encoders of
      cables whose measured tension is within three standard deviations of 0 are not used. The errors of tension and
      stretch are further states: ekf_tension_errors.py.
    - range, scan: not used, as the nominal robot contains no map of the obstacles.

    The noise of a sensor follows from its nominal noise and resolution. Measurements with a delay are used at the time
    at which they were taken; the filter is then repeated up to the present. Cables that sag are rejected. Friction of
    pulleys and the creep of cables are not in the model.
    """

    def __init__(
        self, robot: Robot, gravity: Array, control_step: float, sensors: Sequence[SensorModel], options: Any
    ) -> None:
        super().__init__(robot, gravity, control_step, sensors, options)
        given = [each.sensor for each in sensors]
        needs_tensions = set(commands_of(robot)) != {TENSION}
        self.ignored = {
            each.title: reason
            for each in given
            if (reason := reason_to_ignore(each, given, needs_tensions=needs_tensions))
        }
        self._used = [each for each in sensors if each.title not in self.ignored]
        _check_used(self._used, given)
        _check_cables(robot, self._used)
        used = [each.sensor for each in self._used]
        tables = sensor_tables(used, robot.m, options.noise_floor)
        cells = _cells(used)
        deviations_of_cells = None if cells is None else deviations(cells, robot.m, options.noise_floor)
        every = 1 if cells is None else max(1, round(cells.period / control_step))
        slots = 3 + max(_late(each, control_step) for each in used)  # one more for load cells
        width = STATE_NUMBERS + 3 * robot.m + tables.values + len(used)
        if cells is not None:
            slots += _late(cells, control_step) + 2 * every  # to the measurement before a lost one
            width += 2 + numbers_of_errors(robot.m)
        self._values, self._arrivals = np.zeros(tables.values), np.zeros((len(used), 2))
        self._history, self._count = np.zeros((slots, width)), np.zeros(1)
        self.covariance, innovation = np.zeros((ERRORS, ERRORS)), np.zeros(2)
        self.nis, self.nis_size = innovation[:1], innovation[1:]
        self.arrays = (self._values, self._arrivals, self._history, self._count, self.covariance, innovation)
        self._state, self._time = np.zeros(13), np.zeros(1)
        self._given = {
            **platform_arguments(robot, gravity, control_step, options, deviations_of_cells),
            "time": self._time,
            "start": np.zeros(13),
            "deviation": start_deviations(robot, options),
            "command": np.zeros(robot.m),
            "sensors": tables.rows,
            "values": self._values,
            "arrivals": self._arrivals,
            "deviations": tables.deviations,
            "settings": tables.settings,
            "history": self._history,
            "count": self._count,
            "every": every,
            "overdue": OVERDUE * every + (0 if cells is None else _late(cells, control_step)),
            "covariance": self.covariance,
            "innovation": innovation,
        }
        self._operations: Sequence[Callable[..., object]] = ()

    def connect(self, inputs: EstimatorInputs) -> None:
        """Use the tensions as sent and the given start."""
        self._given["start"] = inputs.start
        self._given["command"] = inputs.tension
        self._operations = self.compiled(self._state)
        self._given["time"] = inputs.time  # of operations for the loop; `estimate` sets its own

    def estimate(self, time: float, out: Array) -> None:
        """Write the estimate (13,)."""
        self._time[0] = time
        for operation in self._operations:
            operation()
        out[:] = self._state

    def compiled(self, out: Array) -> Sequence[Callable[..., object]]:
        """Return the operations: one for each sensor, and the filter."""
        place, takes = 0, []
        for sensor, arrival in zip(self._used, self._arrivals, strict=True):
            end = place + len(sensor.measured)
            live = {"measured": sensor.measured, "fresh": sensor.fresh, "age": sensor.age}
            takes.append(bind("take_measurement", **live, values=self._values[place:end], arrival=arrival))
            place = end
        return (*takes, bind("kalman_filter", **self._given, state=out))

    def reset(self) -> None:
        """Clear the memory; the filter starts at time 0."""
        for array in self.arrays:
            array[:] = 0.0

    def describe(self) -> dict[str, Any]:
        """Return the sensors that are used, and why others are not."""
        return {"used": [each.title for each in self._used], "ignored": self.ignored}


def start_deviations(robot: Robot, options: Any) -> Array:
    """Return the standard deviations of the start, (12,); 0 in blocked directions."""
    free = np.zeros(6)
    free[robot.rows] = 1.0
    each = [options.position_error, options.rotation_error, options.velocity_error, options.turn_rate_error]
    return np.asarray(np.repeat(each, 3) * np.tile(free, 2))


def _check_used(used: Sequence[SensorModel], given: Sequence[Sensor]) -> None:
    if any(each.sensor.measurement != "tension" for each in used):
        return
    present = ", ".join(each.type for each in given) or "none"
    allowed = ", ".join(each for each in USED if each != "tension")
    raise CdprError(f"ekf: sensors: expected at least one of {allowed}, got {present}; add one to `sensors`")


def _late(sensor: Sensor, step: float) -> int:
    """Return the largest number of control steps from a measurement to its arrival."""
    late = round((sensor.delay + sensor.jitter) / step)
    held = late + round(sensor.period / step) if sensor.measurement == "tension" else late
    if held > MOST_LATE:
        times = "delay and jitter" if held == late else "period, delay and jitter together"
        raise CdprError(
            f"ekf: sensor '{sensor.title}': expected {times} of at most {MOST_LATE} control steps, got {held}; reduce "
            "them"
        )
    return late


def _check_cables(robot: Robot, used: Sequence[SensorModel]) -> None:
    """Raise CdprError for cables that sag, and for encoders on cables that stretch under unknown tensions."""
    if bends(robot):
        raise CdprError(
            f"ekf: the cables of '{robot.name}' sag, but the filter has a model of straight cables only; set "
            "`believed` to a robot with another cable model, such as elastic"
        )
    kinds = {each.sensor.measurement for each in used}
    unknown = [
        cable.name
        for cable, command in zip(robot.cables, commands_of(robot), strict=True)
        if command != TENSION and chain_of(robot, cable).stretches
    ]
    if unknown and "encoders" in kinds and "tension" not in kinds:
        raise CdprError(
            f"ekf: sensors: encoders do not measure the stretch of {', '.join(unknown)}, whose winches take lengths or "
            "rates; add `- type: tension` to sensors, or replace the encoders"
        )


def _cells(used: Sequence[Sensor]) -> Sensor | None:
    return next((each for each in used if each.measurement == "tension"), None)
