"""Sum of the external wrenches of events at each sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import bind


@dataclass(frozen=True, eq=False)
class Loads:
    """External wrench (6,): N and N m at the platform's origin, world axes, live."""

    row: Array  # of the present sample
    plant: Array  # in the backend

    def writing(self, loads: Array) -> Callable[[int], bool]:
        """Return a function that writes the wrench at a sample, and returns whether it differs at the next one.

        Args:
            loads: (k, 10) first sample, sample after the last, angle per sample and first angle of the sine that
                multiplies the amplitude (rad; a quarter turn for a constant load), amplitude (6).
        """
        number = np.zeros(1, dtype=np.int64)
        call = bind("external_loads", loads=loads, sample=number, external=self.row)

        def write(sample: int) -> bool:
            number[0] = sample
            return bool(call())

        return write
