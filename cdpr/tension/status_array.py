"""Array of statuses that prints names."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.tension.status import Status


def _name(value: Any) -> str:
    return Status(value).name


class StatusArray(np.ndarray[Any, np.dtype[np.int64]]):
    """Integer array of `cdpr.tension.Status`: compares and counts as integers, prints as names."""

    def __new__(cls, values: NDArray[Any]) -> StatusArray:
        """Return a copy of `values`, whole numbers, as statuses."""
        return values.astype(np.int64).view(cls)

    def __getitem__(self, key: Any) -> Any:
        """Return one Status or an array of them."""
        found = super().__getitem__(key)
        return found if isinstance(found, np.ndarray) else Status(found)

    def __str__(self) -> str:
        return np.array2string(self.view(np.ndarray), formatter={"int": _name})

    __repr__ = __str__

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """Return results computed from statuses, such as comparisons, as plain arrays."""
        return array[()] if return_scalar else array
