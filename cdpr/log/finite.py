"""Check of a run's samples for non-finite values, block by block."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.base.columns import NEED_NOT_BE_FINITE
from cdpr.log.layout import Layout
from cdpr.model.robot import Array


class Finite:
    """Search for non-finite logged values.

    The columns of `cdpr.base.columns.NEED_NOT_BE_FINITE` are not checked. In columns of plugins, NaN means "no value".

    Args:
        layout: columns of the run.
        period: time between two rows, s.
        names: columns of the rows, in this order; all by default.

    Attributes:
        fault: description of the first such value; "" if there is none.
    """

    def __init__(self, layout: Layout, period: float, names: Sequence[str] = ()) -> None:
        fields = [layout.fields[name] for name in names or layout.fields]
        self._columns = [column for column in fields for _ in range(column.width or layout.m)]
        self._checked = np.array([column.name not in NEED_NOT_BE_FINITE for column in self._columns])
        self._strict = np.array([not column.owner for column in self._columns])
        self._period = period
        self._count = 0
        self.fault = ""

    def rewind(self, stop: int) -> None:
        """Continue at sample `stop`; all earlier ones are finite."""
        self._count, self.fault = stop, ""

    def take(self, rows: Array, stop: int) -> None:
        """Check the unchecked samples up to `stop` (excluded); sample k is in rows[k % len(rows)]."""
        size = len(rows)
        first, self._count = max(self._count, stop - size), stop
        while first < stop and not self.fault:
            n = min(stop - first, size - first % size)
            self._check(rows[first % size : first % size + n], first)
            first += n

    def _check(self, block: Array, first: int) -> None:
        finite = np.isfinite(block)
        if finite.all():
            return
        wrong = ~finite & self._checked & (self._strict | ~np.isnan(block))
        if not wrong.any():
            return
        k, at = divmod(int(np.argmax(wrong)), wrong.shape[1])
        column = self._columns[at]
        owner = f" of the {column.owner}" if column.owner else ""
        self.fault = (
            f"the logged value '{column.name}'{owner} is {block[k, at]:g} at t = {(first + k) * self._period:.6g} s; "
            "expected a finite number"
        )
