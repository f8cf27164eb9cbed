"""Numbers that `proceed.hpp` gives a meaning."""

from __future__ import annotations

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
