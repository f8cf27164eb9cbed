"""Check that the samples of a run are finite, block by block."""

from __future__ import annotations

import numpy as np

from cdpr.columns import MAY_BE_NAN
from cdpr.log.layout import Layout
from cdpr.model.robot import Array


class Finite:
    """Search for logged values that are not finite.

    NaN is allowed in the columns of `cdpr.columns.MAY_BE_NAN` and in those of plugins, where it is "no value".

    Attributes:
        fault: the first such value, "" while there is none.
    """

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._strict = np.ones(layout.width, dtype=bool)
        for name, column in layout.fields.items():
            if name in MAY_BE_NAN or column.owner:
                self._strict[layout.columns[name]] = False
        self._count = 0
        self.fault = ""

    def rewind(self, stop: int) -> None:
        """Forget the samples from `stop` on."""
        if stop < self._count:
            self._count, self.fault = stop, ""

    def take(self, rows: Array, stop: int) -> None:
        """Check the samples up to `stop`, excluded, that were not yet checked; sample k is in rows[k % len(rows)]."""
        size = len(rows)
        first, self._count = max(self._count, stop - size), stop
        while first < stop and not self.fault:
            n = min(stop - first, size - first % size)
            self._check(rows[first % size : first % size + n])
            first += n

    def _check(self, block: Array) -> None:
        finite = np.isfinite(block[:, : self._layout.width])
        if finite.all():
            return
        wrong = ~finite & (self._strict | ~np.isnan(block[:, : self._layout.width]))
        if not wrong.any():
            return
        k, at = divmod(int(np.argmax(wrong)), self._layout.width)
        name = next(name for name, span in self._layout.columns.items() if span.start <= at < span.stop)
        column = self._layout.fields[name]
        owner = f" of the {column.owner}" if column.owner else ""
        self.fault = f"the column '{name}'{owner} is not finite from t = {block[k, 0]:.6g} s on: {block[k, at]:g}"
