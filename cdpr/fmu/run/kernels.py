"""Signals in and out of the values of an FMU, all of one array in one call."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr import tolerances
from cdpr.model.jit import kernel
from cdpr.model.robot import Array

EXACT = 1e-12  # of the square: what is nearer to 1 was normalised by the FMU
NEARLY = 2.0 * tolerances.UNIT  # of the square

Index = NDArray[np.int64]


@kernel
def gather(places: Index, index: Index, scale: Array, offset: Array, values: Array, out: Array) -> None:
    """out[places] = values[index] * scale + offset."""
    for k in range(places.shape[0]):
        out[places[k]] = values[index[k]] * scale[k] + offset[k]


@kernel
def scatter(places: Index, index: Index, scale: Array, offset: Array, signals: Array, values: Array) -> None:
    """values[index] = (signals[places] - offset) / scale."""
    for k in range(places.shape[0]):
        values[index[k]] = (signals[places[k]] - offset[k]) / scale[k]


@kernel
def normalise(state: Array) -> None:
    """Make the quaternion of a state (13,) exactly as long as it should be, where it nearly is."""
    square = state[3] ** 2 + state[4] ** 2 + state[5] ** 2 + state[6] ** 2
    if EXACT < abs(square - 1.0) < NEARLY:
        norm = math.sqrt(square)
        for i in range(3, 7):
            state[i] /= norm
