"""The external wrench that events add up to, at each sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import bind


@dataclass(frozen=True, eq=False)
class Loads:
    """Where the external wrench (6,) stands: N and N m at the platform's origin, world axes, live."""

    row: Array  # in the present sample
    plant: Array  # in the backend

    def writing(self, loads: Array) -> Callable[[int], bool]:
        """Return a function that writes the wrench at a sample, and returns whether it differs at the next.

        Args:
            loads: (k, 10), first sample, sample at which it has ended, angle per sample and first angle of the sine by
                which the amplitude is multiplied (rad; a quarter turn where it does not swing), amplitude (6).
        """
        number = np.zeros(1, dtype=np.int64)
        call = bind("external_loads", loads=loads, sample=number, external=self.row)

        def write(sample: int) -> bool:
            number[0] = sample
            return bool(call())

        return write
