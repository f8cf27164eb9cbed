"""Broken backends with winches, each with the checks that must catch it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from cdpr_traps.backend import Wrapped


class IdealAnyway(Wrapped):
    """It declares winches, but moves with ideal cables."""

    def __init__(self, robot, *rest):
        super().__init__(replace(robot, cable_model="ideal"), *rest)


class LateRates(Wrapped):
    """Its winches unwind at half of the commanded rates."""

    def winch_readings(self, *arrays):
        return self.inner.winch_readings(*arrays)

    def read_tension(self, tension):
        self.inner.command[:] = self.command
        self.inner.read_tension(tension)

    def step(self, n):
        given = self.command.copy()
        if np.abs(given).max() < 1.0:
            self.command *= 0.5
        super().step(n)
        self.command[:] = given


MUTANTS = {
    LateRates: ({"features": ["winch_commands"]}, ["winches_wind_as_commanded"]),
    IdealAnyway: ({"cable_models": ["ideal", "elastic"]}, ["winches_pull_as_reported"]),
}
