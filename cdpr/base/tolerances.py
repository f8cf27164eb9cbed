"""Tolerances of user input, defined only here.

Round-off tolerances of algorithms depend on their arithmetic and are defined with them.
"""

from __future__ import annotations

# Relative. Times and steps are decimal fractions, whose sums and ratios have rounding errors as floats.
TIME = 1e-9

# Deviation of a quaternion's length from 1: rounding to three decimals is below it, errors above.
UNIT = 1e-3

# Smaller entries of a quaternion or a position (m) are zero: rounding of decimals, no motion.
HELD = 1e-9

# m; shorter cables have no direction, and closer anchors are identical.
LENGTH = 1e-6
