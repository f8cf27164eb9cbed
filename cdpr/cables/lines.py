"""Layout of the rows that the kernels of exits in Python take: what the C of exported FMUs is tested against."""

from __future__ import annotations

# First column of an exit's numbers; before it the anchors A_i, world, and B_i, platform axes, and three unused columns.
NUMBERS = 9
