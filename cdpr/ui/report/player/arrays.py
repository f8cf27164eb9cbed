"""Numeric arrays of a page: one base64 block, with the offset and type of each array."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np

from cdpr.model.robot import Array

STEPS = 65534  # of a quantised array; the next number marks values that are not finite
FLOAT32 = 3e38  # values are clipped to the range of float32
LARGEST = 1e307  # twice this value is still finite


class Arrays:
    """Collector of the arrays of one page."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def coarse(self, values: Any) -> dict[str, Any]:
        """Add an array (n,) quantised to 65535 steps between minimum and maximum, 2 bytes a value: for drawing."""
        values = np.asarray(values, dtype=np.float64).ravel()
        finite = np.isfinite(values)
        values = np.where(finite, np.clip(values, -LARGEST, LARGEST), values)
        low, high = (float(values[finite].min()), float(values[finite].max())) if finite.any() else (0.0, 0.0)
        scale = (high - low) / STEPS or 1.0
        if low < 0.0 < high:  # zero is a step, so that it is shown as 0
            scale = (high - low) / (STEPS - 1) or 1.0
            low = -math.ceil(-low / scale) * scale
        steps = np.full(len(values), STEPS + 1, "<u2")
        steps[finite] = np.minimum(np.rint((values[finite] - low) / scale), STEPS).astype("<u2")
        return {**self._add(steps, "u2"), "low": low, "scale": scale}

    def fine(self, values: Any) -> dict[str, Any]:
        """Add an array (n,) as float32, 4 bytes a value: for values of very different magnitudes."""
        values = np.asarray(values, dtype=np.float64).ravel()
        return self._add(np.clip(values, -FLOAT32, FLOAT32).astype("<f4"), "f4")

    def small(self, values: Any) -> dict[str, Any]:
        """Add an array (n,) of integers from 0 to 255."""
        return self._add(np.asarray(values).ravel().astype("u1"), "u1")

    def text(self) -> str:
        """Return all arrays as one base64 block."""
        return base64.b64encode(b"".join(self._parts)).decode()

    def _add(self, values: Array | Any, kind: str) -> dict[str, Any]:
        data = values.tobytes()
        data += b"\0" * (-len(data) % 4)  # typed arrays must be aligned to their element size
        entry = {"at": self._size, "n": len(values), "kind": kind}
        self._parts.append(data)
        self._size += len(data)
        return entry
