"""Compiled control laws for calls with changing arrays."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cdpr.model.robot import Array


class Law:
    """Compiled law, bound once to its own arrays.

    Args:
        bound: function that binds the law to a state (13,), a desired state (19,) and an output, as
            `Controller.compiled`.
        width: width of the output, 6 for a wrench, m for commands.
    """

    def __init__(self, bound: Callable[[Array, Array, Array], Callable[[], object]], width: int) -> None:
        self._state, self._desired, self._out = np.zeros(13), np.zeros(19), np.zeros(width)
        self._call = bound(self._state, self._desired, self._out)

    def __call__(self, state: Array, desired: Array, out: Array) -> None:
        """Write the output for a state (13,) and a desired state (19,)."""
        self._state[:] = state
        self._desired[:] = desired
        self._call()
        out[:] = self._out
