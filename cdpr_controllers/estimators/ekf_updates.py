"""Sensors of an extended Kalman filter: which measurements it uses, and with which noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.sensing.sensor import Sensor

# Models of measurements (`Sensor.measurement`) in the order of `FilteredSensor`, ekf_updates.hpp.
USED = ("pose", "twist", "encoders", "receiver", "imu", "markers", "tension")


def reason_to_ignore(sensor: Sensor, sensors: Sequence[Sensor], *, needs_tensions: bool) -> str:
    """Return why the filter does not use a sensor; "" if it does.

    Args:
        sensor: one of the sensors.
        sensors: all, of which only the first load cells count.
        needs_tensions: True if commands are not tensions.
    """
    if sensor.measurement not in USED:
        return sensor.not_estimated
    if sensor.measurement == "tension":
        if not needs_tensions:
            return "the commands are the tensions"
        if sensor is not next(each for each in sensors if each.measurement == "tension"):
            return "the filter uses the first load cells only"
    return ""


class SensorTables(NamedTuple):
    """Tables of the used sensors, as in ekf.hpp.

    Attributes:
        rows: (k, 5), places of each sensor in the others.
        deviations: (d,), standard deviations of the noise of all components.
        settings: (q,), numbers of the sensors.
        values: number of their values.
    """

    rows: NDArray[np.int64]
    deviations: Array
    settings: Array
    values: int


def deviations(sensor: Sensor, cables: int, floor: float) -> Array:
    """Return the standard deviation of each component of a sensor, from its noise and resolution.

    A value rounded to multiples of r has an error with the standard deviation r / sqrt(12). Bias, drift and gain are
    not known to the filter.

    Args:
        sensor: sensor as believed.
        cables: number of cables.
        floor: smallest standard deviation, in the unit of the component.
    """
    _, _, noise, _, resolution = np.array(sensor.errors(cables)).T
    return np.asarray(np.maximum(floor, np.hypot(noise, resolution / np.sqrt(12.0))))


def sensor_tables(sensors: Sequence[Sensor], cables: int, floor: float) -> SensorTables:
    """Return the tables of the used sensors.

    Args:
        sensors: the used sensors, as believed.
        cables: number of cables.
        floor: smallest standard deviation of a component.
    """
    rows: list[list[int]] = []
    noise: list[float] = []
    numbers: list[float] = []
    values = 0
    for sensor in sensors:
        count = sum(each.values(cables) for each in sensor.quantities)
        rows.append([USED.index(sensor.measurement), values, len(noise), len(numbers), count])
        noise += deviations(sensor, cables, floor).tolist()
        numbers += sensor.measurement_numbers()
        values += count
    return SensorTables(np.array(rows, dtype=np.int64), np.array(noise), np.array(numbers), values)
