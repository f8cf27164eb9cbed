"""The external wrench that events add up to, at each sample."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cdpr.model.jit import kernel
from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Loads:
    """Where the external wrench (6,) stands: N and N m at the platform's origin, world axes, live."""

    row: Array  # in the present sample
    plant: Array  # in the backend


@kernel
def write_loads(loads: Array, k: int, external: Array) -> bool:
    """Write the wrench (6,) at sample k and return whether it will be another one at the next.

    Rows of `loads`: first sample, sample at which it has ended, angle per sample and first angle of the sine that the
    amplitude is multiplied by (rad; a quarter turn for what does not swing), amplitude (6).
    """
    swinging = False
    for j in range(6):
        external[j] = 0.0
    for i in range(loads.shape[0]):
        if loads[i, 0] <= k < loads[i, 1]:
            swinging = swinging or loads[i, 2] > 0.0
            part = math.sin(loads[i, 3] + (k - loads[i, 0]) * loads[i, 2])
            for j in range(6):
                external[j] += part * loads[i, 4 + j]
    return swinging
