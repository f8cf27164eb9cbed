"""Immutable data, also after copying."""

from __future__ import annotations

from typing import Any

import numpy as np


class Frozen:
    """Mixin that keeps read-only arrays in attributes, or in mappings there, read-only in copies and unpickled objects.

    (Numpy does not: pickled or copied arrays are writeable.)
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            for array in value.values() if isinstance(value, dict) else (value,):
                if isinstance(array, np.ndarray):
                    array.flags.writeable = False
        self.__dict__.update(state)
