"""Data that stays as it is, also in copies."""

from __future__ import annotations

from typing import Any

import numpy as np


class Frozen:
    """Read-only arrays in the attributes, or in a mapping there, are read-only in copied and unpickled objects, too.

    (Numpy forgets that: an array that was pickled or copied can be written to.)
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            for array in value.values() if isinstance(value, dict) else (value,):
                if isinstance(array, np.ndarray):
                    array.flags.writeable = False
        self.__dict__.update(state)
