"""Constants shared with `step_kernel.hpp`."""

from __future__ import annotations

# Results of the compiled code beside the codes of operations, which are small: the goal is reached; Python's turn.
PYTHON, REACHED = 1 << 29, 1 << 30

# Columns of the table of operations: function, argument and due sample; function and argument of the handler of a
# result other than 0, and number of operations to skip if the handler returns 0.
CALLED, GIVEN, WHEN, MENDS, MENDS_GIVEN, SKIP = range(6)
NEVER, ALWAYS, DUE = range(3)
KEEP, TICK = 1, 2  # markers without a function: the sample is complete; the time of the next one begins

# Position: the next sample and operation, the sample and operation at which to stop, and the sample at which something
# is due.
SAMPLE, OPERATION, LAST, LAST_OPERATION, DUE_AT = range(5)
