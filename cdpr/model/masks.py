"""Detection of masked arrays: numpy drops masks silently where it converts, and uses the numbers below them."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

MASKED = "some values are masked, so there are none; fill them in or leave them out"


def masked(values: Any) -> bool:
    """Return whether an array, or one in lists and tuples, has masked values."""
    if "numpy.ma" not in sys.modules:  # takes long to import; nothing is masked before it is
        return False
    if isinstance(values, np.ma.MaskedArray):
        return bool(np.ma.getmaskarray(values).any())
    return isinstance(values, list | tuple) and any(map(masked, values))
