"""Brakes of winches, which hold the drums without power.

A brake is released by power, and closes a delay after it is cut. Until then, the drum turns under the tension of its
cable, without torque of its motor. Then dry friction of the brake torque M_b (N m) acts on the drum:

    I w' = -f(w) - r T - M_b sign(w),   and w = 0 while |r T| <= M_b

A drum that comes to rest stays there (stick and slip; Karnopp, J. Dyn. Sys. Meas. Control 107 (1985) 100-103). A winch
without an inertia stops at once and holds its length, whatever the torque; its brake has no delay.
"""

from __future__ import annotations

import math

from cdpr.base.fields import NonNegative, Positive
from cdpr.cables.chain import Number
from cdpr.model import Cable

TORQUE = Number("winch.brake_torque", Positive, "N m", "torque of the brake about the drum's axis; without it no brake")
DELAY = Number("winch.brake_delay", NonNegative, "s", "delay from the power cut to the torque of the brake", 0.0)
NUMBERS = (TORQUE, DELAY)


def brake_of(cable: Cable) -> tuple[float, float] | None:
    """Return torque (N m) and delay (s) of the brake of a cable's winch; None without a brake."""
    torque = TORQUE.of(cable, math.nan) if cable.winch is not None else math.nan
    return None if math.isnan(torque) else (torque, DELAY.of(cable))
