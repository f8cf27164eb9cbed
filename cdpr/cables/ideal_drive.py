"""Ideal drive: it pays out at the commanded rate V (m/s), l0' = V.

With the command of a length L (m), the loop commands the rate at which the drive reaches L at the end of the control
period, as drives do that interpolate positions.
"""

from __future__ import annotations

from cdpr.base.needs import of_length_winch
from cdpr.cables.chain import COORDINATE, Winch
from cdpr.cables.drum import RADIUS
from cdpr.cables.transmission import GEOMETRY

IDEAL_DRIVE = Winch(
    header="cdpr/cables/ideal_drive.hpp",
    numbers=(RADIUS,),
    transmission=GEOMETRY,
    without={RADIUS.name: 1.0},  # m: without a drum the coordinate is a length
    command="rate",
    states=COORDINATE,
    needs=of_length_winch(),
)
