"""Currents, voltages and electrical energies of motors, counted during a run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from cdpr.log.header import Header
from cdpr.model.robot import Array

COLUMNS = "motor_current", "motor_voltage", "electrical_power"


class Electrical(NamedTuple):
    """Figures of the motors so far; NaN for motors without electrical data.

    Attributes:
        time: time of the last sample, s.
        power: (m,), W, electrical powers of the last sample; None before it.
        largest: (2, m), largest magnitudes of current, A, and voltage, V.
        sums: (3, m), integrals over time of the squared current, A^2 s, and of the power used and fed back, J.
        squared: (m,), A^2, squared currents of the last sample.
    """

    time: float = 0.0
    power: Array | None = None
    largest: Array = np.zeros((2, 0))
    sums: Array = np.zeros((3, 0))
    squared: Array = np.zeros(0)

    def added(self, time: Array, current: Array, voltage: Array, power: Array) -> Electrical:
        """Return the figures including the next samples: times (n,), s, and values (n, m).

        Integrals are by the trapezoidal rule, summed in the order of the samples: batches of any size give equal bits.
        """
        largest = np.array([np.abs(current).max(axis=0), np.abs(voltage).max(axis=0)])
        last = power[-1].copy(), current[-1] ** 2
        flows = np.stack([current**2, np.maximum(power, 0.0), np.maximum(-power, 0.0)])
        sums = np.zeros((3, power.shape[1]))
        if self.power is not None:
            largest, sums = np.maximum(largest, self.largest), self.sums
            before = np.stack([self.squared, np.maximum(self.power, 0.0), np.maximum(-self.power, 0.0)])
            flows, time = np.concatenate([before[:, None], flows], axis=1), np.concatenate([[self.time], time])
        parts = 0.5 * (flows[:, 1:] + flows[:, :-1]) * np.diff(time)[:, None]
        sums = np.cumsum(np.concatenate([sums[:, None], parts], axis=1), axis=1)[:, -1]
        return Electrical(float(time[-1]), last[0], largest, sums, last[1])

    def figures(self, start: float) -> dict[str, Any]:
        """Return plain figures of a run from `start` (s) on, {} without motors with electrical data."""
        if self.power is None or np.isnan(self.largest).all():
            return {}
        current, voltage = np.nanmax(self.largest, axis=1).tolist()
        squared, used, regenerated = self.sums
        span = self.time - start
        rms = float(np.sqrt(np.nanmax(squared) / span)) if span > 0.0 else current
        return {
            "motor_current_A": {"max": current, "rms": rms},
            "motor_voltage_V": {"max": voltage},
            "electrical_energy_J": {"used": float(np.nansum(used)), "regenerated": float(np.nansum(regenerated))},
        }


def electrical(found: Electrical, header: Header, rows: Array) -> Electrical:
    """Return the figures including the next samples of a run, (n, width); unchanged without electrical columns."""
    if not header.layout.has("electrical") or not len(rows):
        return found
    current, voltage, power = (np.asarray(rows[:, header.layout.columns[name]]) for name in COLUMNS)
    return found.added(rows[:, 0], current, voltage, power)
