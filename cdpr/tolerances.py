"""By how much what a user gives may miss what it means: here and nowhere else.

What an algorithm calls round-off depends on its arithmetic and stands beside it.
"""

from __future__ import annotations

# Relative. Times and steps are decimal fractions, of which floats miss sums and ratios by rounding.
TIME = 1e-9

# How far the length of a quaternion may be from 1: rounded to three decimals it is nearer, mistakes are farther.
UNIT = 1e-3

# Entries of a quaternion or a position (m) below this are zero as typed: rounding of decimals, no motion.
HELD = 1e-9

# m; a cable shorter than this has no direction, and anchors nearer than this are one point.
LENGTH = 1e-6
