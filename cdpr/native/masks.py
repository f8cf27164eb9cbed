"""Detection of masked arrays, whose masks numpy drops silently in conversions."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

MASKED = "masked values are not supported; fill them in or remove them"


def masked(values: Any) -> bool:
    """Return True if an array, or one in lists and tuples, has masked values."""
    if "numpy.ma" not in sys.modules:  # slow to import; without it nothing is masked
        return False
    if isinstance(values, np.ma.MaskedArray):
        return bool(np.ma.getmaskarray(values).any())
    return isinstance(values, list | tuple) and any(map(masked, values))
