"""Standard messages of sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.model.robot import Array

XYZW = [1, 2, 3, 0]  # order of quaternions in ROS

Columns = Callable[[str], Array]  # values (n, w) of a quantity, by its key


@dataclass(frozen=True)
class Message:
    """Standard message of a sensor.

    Attributes:
        kind: message type, "package/Type".
        fields: fields by path, each with the function that returns its numbers (n, w), as float64.
        constant: other fields with their values, and sequences of the right length.
        framed: True if the values are in the frame of the sensor, False if they are in that of the world.
        topic: last part of its topic, after the name of the sensor; "" for none.
    """

    kind: str
    fields: Mapping[str, Callable[[Columns], Array]]
    constant: Mapping[str, Any]
    framed: bool = False
    topic: str = ""


def quantity(key: str, order: Any = slice(None)) -> Callable[[Columns], Array]:
    """Return the function that reads a quantity, its values in this order."""
    return lambda read: read(key)[:, order]


def pose_covariance(linear: float, angular: float) -> list[float]:
    """Return the diagonal covariance (36) of a pose or twist with these standard deviations."""
    return np.diag(np.repeat([linear, angular], 3) ** 2).ravel().tolist()


def covariance(deviation: float) -> list[float]:
    """Return the diagonal covariance (9) of a vector."""
    return np.diag(np.full(3, deviation) ** 2).ravel().tolist()


def singles(values: Array) -> Array:
    """Return numbers (n, w) as float32, two in each float64; an odd one is followed by a zero."""
    padded = np.zeros((len(values), values.shape[1] + values.shape[1] % 2), "<f4")
    padded[:, : values.shape[1]] = values
    return padded.view(np.float64)
