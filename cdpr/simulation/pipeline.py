"""Pipeline of a step of the loop, run by compiled code and, where necessary, by Python.

A step is a list of operations. Compiled code calls kernels with their arguments, one after the other and step after
step, until it reaches an operation of Python, or one returns a value other than 0. Python then serves that operation,
and the compiled code continues after it. The order and the bits therefore do not depend on the kinds of the parts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError, Infeasible
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind
from cdpr.simulation.step_kernel import (
    ALWAYS,
    CALLED,
    DUE,
    DUE_AT,
    GIVEN,
    KEEP,
    LAST,
    LAST_OPERATION,
    MENDS,
    NEVER,
    OPERATION,
    PYTHON,
    REACHED,
    SAMPLE,
    SKIP,
    TICK,
    WHEN,
)
from cdpr.tension.operations import Operation, report_failed_sample

# Markers in the list: the sample is complete; the time of the next one begins.
COMPLETE, NEXT = Operation("", lambda: None), Operation("", lambda: None)


def bound(call: Callable[..., object]) -> Compiled | None:
    """Return a call as an entry of the compiled table; None if Python must make it."""
    if isinstance(getattr(call, "operation", None), int):
        return cast("Compiled", call)
    return None


class Pipeline:
    """Operations of all steps, and the present position in them.

    Args:
        deciding: operations that complete a sample.
        advancing: operations that take the plant to the next sample and observe it.
        row: present sample.
        period: control period, s.
        beside: another pipeline of the same run, with which this one shares position, time and rows.

    Attributes:
        operations: all operations, in order.
        due: next sample at which something is due.
    """

    def __init__(
        self,
        deciding: Sequence[Operation],
        advancing: Sequence[Operation],
        row: Array,
        period: float,
        beside: Pipeline | None = None,
    ) -> None:
        self.operations = (*deciding, COMPLETE, NEXT, *advancing)
        self._complete = len(deciding)
        known = {id(operation.do): bound(operation.do) for operation in self.operations}  # some occur more than once
        self._bound = [known[id(operation.do)] for operation in self.operations]
        self._table = np.zeros((len(self.operations), 1 + SKIP), dtype=np.int64)
        for line, operation, found in zip(self._table, self.operations, self._bound, strict=True):
            if found is not None:
                line[: GIVEN + 1] = found.operation, found.place
                mend = None if operation.mend is None else bound(operation.mend)  # the operation keeps it alive
                if mend is not None:
                    line[MENDS:] = mend.operation, mend.place, operation.skip
        self._table[[self._complete, self._complete + 1], CALLED] = KEEP, TICK
        pairs = list(zip(self.operations, self._bound, strict=True))
        self._plain = [
            (operation.do, operation.timed) if found is None and operation.unconditional else None
            for operation, found in pairs
        ] + [None]
        self._place, self._time = np.zeros(5, dtype=np.int64), np.zeros(1)
        self._row, self._period, self._rows = row, period, np.zeros((1, len(row)))
        self._run_compiled: Callable[[], int]
        self._without_gil = False
        if beside is not None:
            self._place, self._time, self._without_gil = beside._place, beside._time, beside._without_gil
            self.rows = beside.rows
        # An index into a numpy array costs a tenth of a turn to Python.
        self._at, self._now = self._place.data, self._time.data
        self.refresh()

    @property
    def interpreted(self) -> tuple[str, ...]:
        """Return the owners of operations that Python runs, each once."""
        operations = zip(self.operations, self._bound, strict=True)
        return tuple(
            dict.fromkeys(
                operation.name
                for operation, found in operations
                if found is None and operation.name and not operation.due
            )
        )

    @property
    def count(self) -> int:
        """Return the number of complete samples."""
        return self._at[SAMPLE]

    @property
    def time(self) -> float:
        """Return the time of the present sample, s."""
        return self._now[0]

    @property
    def due(self) -> int:
        """Return the next sample at which something is due."""
        return self._at[DUE_AT]

    @due.setter
    def due(self, sample: int) -> None:
        self._place[DUE_AT] = sample

    @property
    def rows(self) -> Array:
        """Return the storage of the samples: sample k goes to k % len(rows)."""
        return self._rows

    @rows.setter
    def rows(self, rows: Array) -> None:
        width = len(self._row)  # compiled code writes this many numbers, regardless of the table's size
        if not isinstance(rows, np.ndarray) or rows.dtype != np.float64 or rows.ndim != 2 or rows.shape[1] < width:
            raise CdprError(f"rows: expected a float64 table of at least {width} columns, got {np.shape(rows)}")
        self._rows = rows
        self._whole = whole = bind(
            "step_kernel",
            table=self._table,
            place=self._place,
            time=self._time,
            row=self._row,
            rows=rows,
            period=self._period,
        )
        self._run_compiled = whole.unlocked if self._without_gil else whole

    @property
    def place(self) -> tuple[int, int, float, int]:
        """Return the position: sample, operation, time (s), and the sample at which something is due."""
        return self.count, int(self._place[OPERATION]), self.time, self.due

    @place.setter
    def place(self, place: tuple[int, int, float, int]) -> None:
        sample, operation, time, self.due = place
        self._place[SAMPLE], self._place[OPERATION], self._time[0] = sample, operation, time

    @property
    def bound(self) -> Sequence[Compiled | None]:
        """Return the operations as compiled calls, in order; None for those of Python."""
        return self._bound

    @property
    def whole(self) -> Compiled:
        """Return the compiled call that continues from `standing`."""
        return self._whole

    @property
    def standing(self) -> tuple[NDArray[np.int64], Array]:
        """Return the live arrays of position and time, as arguments of `step_kernel`."""
        return self._place, self._time

    @property
    def when(self) -> NDArray[np.int64]:
        """Return the live array of the samples at which each operation is due, as an argument of `step_kernel`."""
        return self._table[:, WHEN]

    def release_gil(self) -> None:
        """Release the GIL during compiled code."""
        self._without_gil = True
        self.rows = self._rows

    def swap(self, operation: Operation, other: Operation) -> bool:
        """Replace an operation by another one; return False if either needs Python."""
        at, found = self.operations.index(operation), bound(other.do)
        if found is None or self._bound[at] is None:
            return False
        self.operations = (*self.operations[:at], other, *self.operations[at + 1 :])
        self._bound[at] = found
        self._table[at, : GIVEN + 1] = found.operation, found.place
        return True

    def refresh(self) -> None:
        """Update for all operations whether they run from now on."""
        for line, operation in zip(self._table, self.operations, strict=True):
            line[WHEN] = (
                DUE if operation.due else NEVER if operation.when is not None and not operation.when() else ALWAYS
            )

    def run_until(self, sample: int, operation: int = 0) -> None:
        """Continue until a sample is observed and not yet decided, or until this operation of it is next."""
        at = self._at
        at[LAST], at[LAST_OPERATION] = sample, operation
        if (code := self._run_compiled()) != REACHED:
            self._serve_python(code)

    def decide(self) -> None:
        """Complete the present sample."""
        self.run_until(self.count + 1, self._complete + 1)

    def mark_complete(self) -> None:
        """Take the position after a sample that a pipeline beside this one has completed."""
        self._place[OPERATION] = self._complete + 1

    def _serve_python(self, code: int) -> None:
        """Serve a return of the compiled code in Python, and continue."""
        operations, plain, turn = self.operations, self._plain, self._run_compiled
        place, time = self._at, self._now
        while code != REACHED:
            at = place[OPERATION]
            try:
                if code != PYTHON:
                    at += 1 + operations[at].meet(code)
                elif plain[at] is None:
                    at += 1 + operations[at](self.time)
                while (found := plain[at]) is not None:
                    do, timed = found
                    answer = do(time[0]) if timed else do()
                    at += 1 if answer is None else 1 + operations[at].meet(answer)
            except Infeasible:
                if at < self._complete:
                    report_failed_sample(operations[at + 1 : self._complete], self.time)
                    self._keep()
                raise
            place[OPERATION] = at
            code = turn()

    def _keep(self) -> None:
        """Store the row of a complete sample."""
        count = self.count
        self._rows[count % len(self._rows)] = self._row
        self._place[[SAMPLE, OPERATION]] = count + 1, self._complete + 1
