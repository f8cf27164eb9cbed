"""What runs acts one after the other, compiled, and the small acts that belong to no part."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from cdpr.model.address import caller
from cdpr.model.bound import ENTRY
from cdpr.model.jit import any_width, kernel, threaded_kernel
from cdpr.model.kinds import WHOLE
from cdpr.model.lanes import choose, code
from cdpr.model.robot import Array

# What the compiled code returns beside the codes of acts, which are small: the goal is reached; Python's turn.
REACHED, PYTHON = 1 << 40, 1 << 41

# Columns of the table of acts: what is called and with what, and when; what is called with what that returns, where it
# is not 0, and how many acts are left out if that returns 0.
CALLED, GIVEN, WHEN, MENDS, MENDS_GIVEN, SKIP = range(6)
NEVER, ALWAYS, DUE = range(3)
KEEP, TICK = 1, 2  # what is called where the sample is complete, and where the time of the next begins: nothing

# Where it stands: the sample and the act that comes next, the sample and the act before which it stops, and the sample
# at which something is due.
SAMPLE, ACT, LAST, LAST_ACT, DUE_AT = range(5)

call_entry = caller(ENTRY)

# An engine's clock is a sum of steps: after 1e8 of them it may be off by this share. A reset is off by much more.
CLOCK_TOLERANCE = 1e-6


@kernel
def proceed(
    table: NDArray[np.int64], place: NDArray[np.int64], time: Array, row: Array, rows: Array, period: float
) -> int:
    """Do acts from where it stands on; return REACHED, PYTHON, or what the act at which it stands returned."""
    sample, act, code = place[SAMPLE], place[ACT], 0
    while code == 0:
        if act == table.shape[0]:
            act = 0
        if sample == place[LAST] and act == place[LAST_ACT]:
            code = REACHED
            break
        called, when = table[act, CALLED], table[act, WHEN]
        if when == ALWAYS or (when == DUE and sample == place[DUE_AT]):
            if called == KEEP:
                kept = rows[sample % rows.shape[0]]
                for i in range(row.shape[0]):
                    kept[i] = row[i]
                sample += 1
            elif called == TICK:
                time[0] = sample * period
            elif called == 0:
                code = PYTHON
                break
            else:
                code = call_entry(called, table[act, GIVEN], time[0])
                if code != 0:
                    mends = table[act, MENDS]
                    if mends == 0 or call_entry(mends, table[act, MENDS_GIVEN], float(code)) != 0:
                        break
                    code = 0
                    act += table[act, SKIP]
        act += 1
    place[SAMPLE], place[ACT] = sample, act
    return code


@kernel
def enter(entry: int, place: int) -> int:
    """Call what is bound: many times cheaper from Python than with arrays as arguments."""
    code: int = call_entry(entry, place, 0.0)
    return code


@cache
def entering_alone() -> Callable[[int, int], int]:
    """Return what does as `enter`, and lets Python's other threads run meanwhile; that costs more than a short call."""

    @threaded_kernel(WHOLE(WHOLE, WHOLE))
    def enter_alone(entry: int, place: int) -> int:
        code: int = call_entry(entry, place, 0.0)
        return code

    return enter_alone


@any_width
@kernel
def stamp(row: Array, time: float) -> None:
    """Write the time (s) of a sample into its row."""
    row[0] = time


@any_width
@kernel
def not_finite(values: Array) -> int:
    """Return whether one of the values (n,) is infinite or no number."""
    found = 0.0
    for i in range(values.shape[0]):
        found += 0.0 * values[i]
    return code(choose(found == 0.0, 0.0, 1.0))


@kernel
def late(clock: Array, time: float) -> bool:
    """Whether an engine's clock (1,), s, is off, or no number."""
    right: bool = abs(clock[0] - time) <= CLOCK_TOLERANCE * time
    return not right


@any_width
@kernel
def ask_nothing(wrench: Array, status: Array) -> None:
    """Where there is no power, nothing is asked of the cables any more: the wrench (6,) and its status are 0."""
    for i in range(wrench.shape[0]):
        wrench[i] = 0.0
    for i in range(status.shape[0]):
        status[i] = 0.0
