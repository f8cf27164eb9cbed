"""What a step of the loop is made of, in order, and what runs it: compiled code, and Python where it must be.

A step is a list of acts. Those that are kernels with their arguments are called by compiled code, one after the other
and step after step, until one is due that is not, or one returns something else than 0: then Python does that, and the
compiled code goes on after it. So there is one order, whatever the parts are made of, and the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from cdpr.errors import CdprError, Infeasible
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind
from cdpr.simulation.proceed import (
    ACT,
    ALWAYS,
    CALLED,
    DUE,
    DUE_AT,
    GIVEN,
    KEEP,
    LAST,
    LAST_ACT,
    MENDS,
    NEVER,
    PYTHON,
    REACHED,
    SAMPLE,
    SKIP,
    TICK,
    WHEN,
)
from cdpr.tension.acts import Act, tell

# They stand in the list where a sample is complete, and where the time of the next begins.
COMPLETE, NEXT = Act("", lambda: None), Act("", lambda: None)


def bound(call: Callable[..., object]) -> Compiled | None:
    """Return a call as compiled code makes it; None where Python must."""
    if isinstance(getattr(call, "operation", None), int):
        return cast("Compiled", call)
    return None


class Program:
    """The acts of all steps, and how far they came.

    Args:
        deciding: what completes a sample.
        advancing: what takes the plant to the next, and looks at it.
        row: the present sample.
        period: control period, s.
        beside: another program of the same run, whose position, time and rows are this one's, too.

    Attributes:
        acts: all of them, in order.
        due: the next sample at which something is due.
    """

    def __init__(
        self,
        deciding: Sequence[Act],
        advancing: Sequence[Act],
        row: Array,
        period: float,
        beside: Program | None = None,
    ) -> None:
        self.acts = (*deciding, COMPLETE, NEXT, *advancing)
        self._complete = len(deciding)
        known = {id(act.do): bound(act.do) for act in self.acts}  # some are done more than once
        self._bound = [known[id(act.do)] for act in self.acts]
        self._table = np.zeros((len(self.acts), 1 + SKIP), dtype=np.int64)
        for line, act, found in zip(self._table, self.acts, self._bound, strict=True):
            if found is not None:
                line[: GIVEN + 1] = found.operation, found.place
                mend = None if act.mend is None else bound(act.mend)  # the act holds it
                if mend is not None:
                    line[MENDS:] = mend.operation, mend.place, act.skip
        self._table[[self._complete, self._complete + 1], CALLED] = KEEP, TICK
        pairs = list(zip(self.acts, self._bound, strict=True))
        self._plain = [(act.do, act.timed) if found is None and act.plain else None for act, found in pairs] + [None]
        self._place, self._time = np.zeros(5, dtype=np.int64), np.zeros(1)
        self._row, self._period, self._rows = row, period, np.zeros((1, len(row)))
        self._turn: Callable[[], int]
        self._apart = False
        if beside is not None:
            self._place, self._time, self._apart = beside._place, beside._time, beside._apart
            self.rows = beside.rows
        # An index into numpy's own array costs a tenth of a turn to Python.
        self._at, self._now = self._place.data, self._time.data
        self.refresh()

    @property
    def interpreted(self) -> tuple[str, ...]:
        """Whose work Python does, each once."""
        acts = zip(self.acts, self._bound, strict=True)
        return tuple(dict.fromkeys(act.name for act, found in acts if found is None and act.name and not act.due))

    @property
    def count(self) -> int:
        """How many samples are complete."""
        return self._at[SAMPLE]

    @property
    def time(self) -> float:
        """Of the sample that is looked at, s."""
        return self._now[0]

    @property
    def due(self) -> int:
        """The next sample at which something is due."""
        return self._at[DUE_AT]

    @due.setter
    def due(self, sample: int) -> None:
        self._place[DUE_AT] = sample

    @property
    def rows(self) -> Array:
        """Where the samples go: sample k to k % len(rows)."""
        return self._rows

    @rows.setter
    def rows(self, rows: Array) -> None:
        width = len(self._row)  # compiled code writes so many numbers, whatever the table has room for
        if not isinstance(rows, np.ndarray) or rows.dtype != np.float64 or rows.ndim != 2 or rows.shape[1] < width:
            raise CdprError(f"rows: a float64 table of at least {width} columns is expected, got {np.shape(rows)}")
        self._rows = rows
        self._whole = whole = bind(
            "proceed",
            table=self._table,
            place=self._place,
            time=self._time,
            row=self._row,
            rows=rows,
            period=self._period,
        )
        self._turn = whole.unlocked if self._apart else whole

    @property
    def place(self) -> tuple[int, int, float, int]:
        """Where it stands: sample, act, time (s), and the sample at which something is due."""
        return self.count, int(self._place[ACT]), self.time, self.due

    @place.setter
    def place(self, place: tuple[int, int, float, int]) -> None:
        self._place[[SAMPLE, ACT]] = place[:2]
        self._time[0], self.due = place[2:]

    @property
    def bound(self) -> Sequence[Compiled | None]:
        """The acts as compiled code calls them, in order; None of those that Python does."""
        return self._bound

    @property
    def whole(self) -> Compiled:
        """What goes on from `standing`, as compiled code calls it."""
        return self._whole

    @property
    def standing(self) -> tuple[NDArray[np.int64], Array]:
        """Where it stands and when that is, live; as `proceed` takes them."""
        return self._place, self._time

    @property
    def when(self) -> NDArray[np.int64]:
        """When each act is done, as `proceed` has it, live."""
        return self._table[:, WHEN]

    def apart(self) -> None:
        """Let Python's other threads run while compiled code does."""
        self._apart = True
        self.rows = self._rows

    def refresh(self) -> None:
        """Ask all acts whether they are done from now on."""
        for line, act in zip(self._table, self.acts, strict=True):
            line[WHEN] = DUE if act.due else NEVER if act.when is not None and not act.when() else ALWAYS

    def look(self, sample: int, act: int = 0) -> None:
        """Go on until a sample is looked at, and nothing of it is decided; or until this act of it is next."""
        at = self._at
        at[LAST], at[LAST_ACT] = sample, act
        if (code := self._turn()) != REACHED:
            self._go(code)

    def decide(self) -> None:
        """Complete the sample that is looked at."""
        self.look(self.count + 1, self._complete + 1)

    def stand(self) -> None:
        """Stand after the sample that a program beside this one has completed."""
        self._place[ACT] = self._complete + 1

    def _go(self, code: int) -> None:
        """Do in Python what the compiled code returned for, and go on."""
        acts, plain, turn = self.acts, self._plain, self._turn
        place, time = self._at, self._now
        while code != REACHED:
            at = place[ACT]
            try:
                if code != PYTHON:
                    at += 1 + acts[at].meet(code)
                elif plain[at] is None:
                    at += 1 + acts[at](self.time)
                while (found := plain[at]) is not None:
                    do, timed = found
                    answer = do(time[0]) if timed else do()
                    at += 1 if answer is None else 1 + acts[at].meet(answer)
            except Infeasible:
                tell(acts[at + 1 : self._complete], self.time)
                self._keep()
                raise
            place[ACT] = at
            code = turn()

    def _keep(self) -> None:
        """Keep the row of a sample of which no more is to come."""
        count = self.count
        self._rows[count % len(self._rows)] = self._row
        self._place[[SAMPLE, ACT]] = count + 1, self._complete + 1
