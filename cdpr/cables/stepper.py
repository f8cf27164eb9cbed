"""Stepper motors that hold the unwound length of a cable in whole steps.

A stepper is a motor and a drum of radius r (m). Its command is the unwound length L (m). The drive turns it into whole
microsteps, and counts the length to which its steps so far lead, L_c. It knows nothing else: without a sensor, it does
not notice lost steps, and later commands are relative to L_c. With a the angle of a full step at the
drum (rad), 2 pi / (steps per turn times gear ratio), and n the number of microsteps in it,

    L_c = r (a / n) round(L n / (r a)),   |L_c'| <= r w_max

The rotor has a stable position in each period of four full steps (Acarnley: Stepping motors, 4th ed., 2002, ch. 3 and
4). Unwound by l0 (m), its torque about the drum's axis (N m) is

    M = M_s sin(pi/2 (l0 - L_c) / (r a))

with the stall torque M_s, the largest one that it can hold. With an `inertia` I and the friction f(w) of a drum
(`cdpr.cables.drum`), w positive when winding in:

    I w' = M - f(w) - r T

If the load exceeds the stall torque, the rotor slips to other periods: the motor loses four full steps each time. At
the start, the drive is calibrated under the load: l0 is then the commanded length.

Without an inertia, the drum follows the steps, l0 = L_c + r a s with s lost steps. An overloaded motor, r T > M_s at a
sample, slips by one period during the following control period, so the speed at which it slips depends on the control
step. While the load remains below M_s, this is the limit of a rotor without inertia, except for its deflection of less
than a full step under load.

The steps of a control period are spread evenly over it.

The transmission (`cdpr.cables.transmission`) applies: with a block and tackle, r is the radius divided by its falls. On
a drum that grows, whole microsteps are angles of the drum from the home pose, and all differences of lengths above are
those of its angle times r. The tension T includes the losses.
"""

from __future__ import annotations

from cdpr.base.fields import AtLeastOne, Positive
from cdpr.base.needs import of_stepper
from cdpr.cables.chain import COORDINATE, Number, Winch
from cdpr.cables.drum import NUMBERS as DRUM_NUMBERS
from cdpr.cables.drum import RADIUS
from cdpr.cables.servo import SPEED_MAX
from cdpr.cables.transmission import COULOMB_SPEED, EFFICIENCY, GEAR_RATIO, GROWTH, LINES, REEVING

STEPS_PER_TURN, MICROSTEPS, STALL_TORQUE = (
    Number("winch.steps_per_turn", AtLeastOne, "", "full steps of a stepper per turn of its motor", 200.0),
    Number("winch.microsteps", AtLeastOne, "", "microsteps in a full step of a stepper", 16.0),
    Number("winch.stall_torque", Positive, "N m", "stall torque, the largest load of a stepper about the drum's axis"),
)
# The numbers of a stepper, in the order of `StepperNumbers`.
STEPS = (STEPS_PER_TURN, MICROSTEPS, STALL_TORQUE, SPEED_MAX, GEAR_RATIO)
TRANSMISSION = (GROWTH, LINES, REEVING, EFFICIENCY)
TYPE = "stepper"  # in robot files
HEADER = "cdpr/cables/stepper.hpp"

STEPPER = Winch(
    header=HEADER,
    numbers=(RADIUS, *STEPS),
    transmission=(*TRANSMISSION, COULOMB_SPEED),
    command="rate",
    states=COORDINATE,
    needs=of_stepper(),
)
STEPPER_MOTOR = Winch(
    header=HEADER,
    numbers=(*DRUM_NUMBERS, *STEPS),
    transmission=TRANSMISSION,
    command="rate",
    states=COORDINATE + 1,
    needs=of_stepper(),
)
STEPPERS = (STEPPER, STEPPER_MOTOR)
