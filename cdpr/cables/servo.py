"""Servos that hold the unwound length of a cable, or its rate.

A servo is a motor and a drum (`cdpr.cables.drum`) with cascaded loops, as in industrial drives. Its command is the
unwound length L (m) or the rate V (m/s). Positive when winding in, with w the speed of the drum and r its radius,

    w_d = kp (l0 - L) / r   (position), or   w_d = -V / r   (velocity)
    e = clip(w_d, w_max) - w
    tau_d = clip(clip(kv e, I a_max) + z, tau_max),   z' = ki e
    lag tau' = tau_d - tau
    I w' = tau - f(w) - r T

The integral z stops while the limit of the torque acts in its direction. Without a lag, tau = tau_d. With kp, kv and ki
to infinity a servo becomes the ideal drive, whose motion is a control period later. At the start the integral holds
the load.
"""

from __future__ import annotations

import math

from cdpr.base.fields import NonNegative, Positive
from cdpr.base.needs import of_length_winch
from cdpr.cables.chain import COORDINATE, Number, Winch
from cdpr.cables.drum import NUMBERS as DRUM_NUMBERS
from cdpr.cables.transmission import TRANSMISSION

OWN_STATES = 2  # integral of the velocity loop, and torque

# The numbers of servos. Limits default to none.
SPEED_MAX = Number("winch.speed_max", Positive, "rad/s", "highest speed of the drum that the drive demands", math.inf)
LOOPS = (
    Number("winch.velocity_gain", Positive, "N m s", "gain of the velocity loop, torque per drum speed"),
    Number("winch.integral_gain", NonNegative, "N m", "integral gain of the velocity loop, torque per angle", 0.0),
    SPEED_MAX,
    Number("winch.acceleration_max", Positive, "rad/s^2", "limit of the velocity loop's proportional part", math.inf),
    Number("winch.torque_max", Positive, "N m", "largest torque of the motor about the drum's axis", math.inf),
    Number("winch.torque_lag", NonNegative, "s", "time constant of the torque, that of the current loop", 0.0),
)
POSITION_GAIN = Number("winch.position_gain", Positive, "1/s", "gain of the position loop", 20.0)
SERVO = "cdpr/cables/servo.hpp"

POSITION_SERVO = Winch(
    header=SERVO,
    numbers=(*DRUM_NUMBERS, *LOOPS, POSITION_GAIN),
    transmission=TRANSMISSION,
    command="length",
    states=COORDINATE + OWN_STATES,
    needs=of_length_winch(),
)
VELOCITY_SERVO = Winch(
    header=SERVO,
    numbers=(*DRUM_NUMBERS, *LOOPS),
    transmission=TRANSMISSION,
    command="rate",
    states=COORDINATE + OWN_STATES,
    needs=of_length_winch(),
)
