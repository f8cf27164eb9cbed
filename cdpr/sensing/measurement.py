"""Measurements of a sensor, from true values at each control step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.model.frozen import given_number
from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.bind import bind
from cdpr.native.random_numbers import Stream
from cdpr.sensing.sensor import Sensor


def kernel_arguments(sensor: Sensor, cables: int, step: float) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the settings and the memory of the operation `measure`.

    Args:
        sensor: sensor.
        cables: number of cables of the robot.
        step: control period, s.

    Returns:
        Settings and memory, by argument; the operation itself puts the memory to its start at time 0.
    """
    widths = [each.values(cables) for each in sensor.quantities]
    n, rates = sum(widths), sum(widths[len(widths) - sensor.rates :])
    attitudes = [sum(widths[:i]) for i, each in enumerate(sensor.quantities) if each.attitude]
    every, delay, jitter = (round(each / step) for each in (sensor.period or step, sensor.delay, sensor.jitter))
    errors = np.array(sensor.errors(cables))
    settings = {
        "errors": errors,
        "step": step,
        "dropout": sensor.dropout,
        "limit": sensor.reach_limit,
        "every": every,
        "delay": delay,
        "jitter": jitter,
        "attitude": attitudes[0] if attitudes else n,
    }
    memory = {
        "walk": np.zeros(len(errors)),
        "previous": np.zeros(rates),
        "pending": np.zeros(((delay + jitter) // every + 2, n + 2)),  # rows: one more than can be on their way
        "held": np.zeros(n + 2),
        "count": np.zeros(4),
    }
    return settings, memory


def measurements(sensor: Sensor, truth: ArrayLike, step: float, seed: int = 0) -> tuple[Array, Array]:
    """Return what a sensor measures of true values, as in a run.

    Args:
        sensor: sensor.
        truth: (K, n), true values of its quantities at K control steps, from time 0.
        step: control period, s.
        seed: seed of the simulation.

    Returns:
        Measured values that are held at each control step (K, n), and their age (K,), s.

    Raises:
        CdprError: if `truth` does not have the width of the sensor, or if the step does not divide its times.

    Example:
        >>> import numpy as np
        >>> from cdpr.sensing import Receiver
        >>> truth = np.arange(5.0)[:, None] * [1.0, 0.0, 0.0]
        >>> measured, age = measurements(Receiver(period=0.02, delay=0.01), truth, 0.01)
        >>> measured[:, 0], age
        (array([0., 0., 0., 2., 2.]), array([0.  , 0.01, 0.02, 0.01, 0.02]))
    """
    truth = real(truth, "truth")
    step = given_number(step, "step", above=0.0)
    for key in ("period", "delay", "jitter"):
        ratio = getattr(sensor, key) / step
        if abs(ratio - round(ratio)) > tolerances.TIME * ratio:
            raise CdprError(f"step: expected a divisor of the {key} {getattr(sensor, key):g} s, got {step:g} s")
    fixed = sum(each.width for each in sensor.quantities)
    per_cable = sum(each.width == 0 for each in sensor.quantities)
    width = truth.shape[1] if truth.ndim == 2 else 0
    cables = (width - fixed) // per_cable if per_cable else 0
    if width < 1 or fixed + per_cable * cables != width:
        raise CdprError(f"truth: expected an array (K, n) of the sensor's n values, got shape {truth.shape}")
    settings, memory = kernel_arguments(sensor, cables, step)
    values, measured, age = np.zeros(width), np.zeros(width), np.zeros(1)
    stream, time = Stream(seed, f"sensors.{sensor.title}").state, np.zeros(1)
    given = {"truth": values, "stream": stream, "time": time, "measured": measured, "age": age}
    measure = bind("measure", **given, **settings, **memory)
    held, ages = np.empty_like(truth), np.empty(len(truth))
    for k, row in enumerate(truth):
        values[:] = row
        time[0] = k * step
        measure()
        held[k], ages[k] = measured, age[0]
    return held, ages
