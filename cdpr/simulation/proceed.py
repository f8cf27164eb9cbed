"""Numbers that `proceed.hpp` gives a meaning, and the small acts that belong to no part."""

from __future__ import annotations

from cdpr.model.jit import any_width, kernel
from cdpr.model.lanes import choose, code
from cdpr.model.robot import Array

# What the compiled code returns beside the codes of acts, which are small: the goal is reached; Python's turn.
PYTHON, REACHED = 1 << 29, 1 << 30

# Columns of the table of acts: what is called and with what, and when; what is called with what that returns, where it
# is not 0, and how many acts are left out if that returns 0.
CALLED, GIVEN, WHEN, MENDS, MENDS_GIVEN, SKIP = range(6)
NEVER, ALWAYS, DUE = range(3)
KEEP, TICK = 1, 2  # what is called where the sample is complete, and where the time of the next begins: nothing

# Where it stands: the sample and the act that comes next, the sample and the act before which it stops, and the sample
# at which something is due.
SAMPLE, ACT, LAST, LAST_ACT, DUE_AT = range(5)

# An engine's clock is a sum of steps: after 1e8 of them it may be off by this share. A reset is off by much more.
CLOCK_TOLERANCE = 1e-6


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
