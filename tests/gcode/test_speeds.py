"""Speeds where one piece of a path meets the next."""

from __future__ import annotations

import numpy as np
import pytest
from motion_cases import UPRIGHT, samples
from test_follow import course, polyline

from cdpr.gcode import follow
from cdpr.trajectory import Limits

BEND = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
LIMITS = Limits(1.0, 0.1, 0.1)  # low, so that the corner is a large one


@pytest.mark.parametrize("speeds", [(0.03, 0.06), (0.06, 0.03)])
def test_the_slower_piece_holds_on_the_rounded_corner(speeds):
    motion = follow(0.0, course(polyline(BEND), np.array(speeds), tolerance=0.05), LIMITS, UPRIGHT)
    _, rows = samples(motion, 4001)
    speed = np.linalg.norm(rows[:, 7:10], axis=1)
    x, y = rows[:, 0], rows[:, 1]
    corner = (x < 1.0 - 1e-9) & (y > 1e-9)
    assert corner.sum() > 10
    for where, most in ((y <= 1e-9, speeds[0]), (corner, min(speeds)), (x >= 1.0 - 1e-9, speeds[1])):
        assert speed[where].max() <= most * (1.0 + 1e-6)
