"""True values of the quantities that sensors measure, from the rows of a run; and the errors of the measurements."""

from __future__ import annotations

import numpy as np

from cdpr.log.header import SOLIDS
from cdpr.log.run import Run
from cdpr.mechanics.solids import rows
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.sensing import Sensor
from cdpr.sensing.records import Records

LEAST = 1e-6  # relative: an age nearer to a whole number of rows is one


def rows_before(run: Run, sensor: Sensor) -> int:
    """Return the number of rows before each row on which the true values of a sensor depend."""
    return max(1, round((sensor.period or run.header.control_step) / run.header.log_step))


def records(run: Run, sensor: Sensor) -> Records:
    """Return the rows of a run, with the obstacles that the sensor sees."""
    head = run.header
    solids = next((each.get(SOLIDS) for each in head.sensors if each["name"] == sensor.title), None)
    return Records(
        state=np.concatenate([run.position, run.orientation, run.velocity, run.angular_velocity], axis=1),
        gravity=np.array(head.gravity),
        step=head.control_step,
        every=head.log_every,
        ideal=head.ideal_cables,
        solids=None if solids is None else rows([np.array(each, dtype=float) for each in solids]),
        column=lambda name: run[name] if name in head.layout.fields else None,
    )


def measured_truth(run: Run, sensor: Sensor, key: str) -> Array | None:
    """Return the true values (K, w) at the time of the measurement that is held at each row, by interpolation.

    The first rows miss those before them, `rows_before`, unless they are those of the whole run. None if the log does
    not determine the values.
    """
    values = sensor.recorded_truth(key, records(run, sensor))
    if values is None:
        return None
    back = run[f"{sensor.title}_age"] / run.header.log_step
    place = np.clip(np.arange(len(back)) - np.nan_to_num(back), 0.0, len(back) - 1.0)
    near = np.rint(place)
    place = np.where(np.abs(place - near) < LEAST * (1.0 + back), near, place)
    low = np.floor(place).astype(np.int64)
    share, high = (place - low)[:, None], np.minimum(low + 1, len(back) - 1)
    return np.where(share > 0.0, (1.0 - share) * values[low] + share * values[high], values[low])


def errors(run: Run, sensor: Sensor, key: str) -> Array | None:
    """Return measured minus true values (K, w), of an attitude as rotation vectors (K, 3), rad, platform axes.

    Values that are not seen, such as those of hidden markers, have the error NaN.
    """
    values = measured_truth(run, sensor, key)
    if values is None:
        return None
    quantity = next(each for each in sensor.quantities if each.key == key)
    measured = run[f"{sensor.title}_{key}"].reshape(len(values), -1)
    if quantity.attitude:
        sizes = np.linalg.norm(values, axis=1, keepdims=True)
        world = rotations.between(values / sizes, measured)
        return rotations.rotate(rotations.conjugate(values / sizes), world)
    if quantity.seen:
        seen = run[f"{sensor.title}_{quantity.seen}"].reshape(len(values), -1) > 0.5
        return np.where(np.repeat(seen, measured.shape[1] // seen.shape[1], axis=1), measured - values, np.nan)
    return measured - values
