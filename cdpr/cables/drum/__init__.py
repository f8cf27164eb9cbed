"""Motor that winds the cable on a drum.

The drum of radius r (m) turns at w (rad/s), positive when winding in. The command u (N) is the tension that the motor
would hold at rest: its torque is r u. Friction takes f(w) = b w + c tanh(w / w_c) of it (N m), viscous and Coulomb, the
latter smoothed about rest. With I the inertia about the drum's axis (kg m^2):

    I w' = r u - f(w) - r T

If the cable does not stretch, l' = -r w, and T = u - f(-l'/r) / r + (I / r^2) l''. Thesis 2.20-2.24, except for the
sign in 2.21: if a drum turns positively when winding in, as in 2.20, q' = -R^-1 J x'; as printed, the drums' inertia
would be subtracted.
"""

from __future__ import annotations

from cdpr.base.fields import NonNegative, Positive
from cdpr.base.needs import of_winch
from cdpr.cables.chain import COORDINATE, Number, Winch
from cdpr.cables.transmission import COULOMB_SPEED, TRANSMISSION

RADIUS = Number("winch.drum_radius", Positive, "m", "radius of the drum: unstretched cable that it winds, per radian")

INERTIA = Number(
    "winch.inertia",
    Positive,
    "kg m^2",
    "moment of inertia of all that turns, motor and gear included, about the drum's axis",
)

NUMBERS = (
    RADIUS,
    INERTIA,
    Number("winch.viscous_friction", NonNegative, "N m s", "friction torque per drum speed", 0.0, exact="N.m.s/rad"),
    Number("winch.coulomb_friction", NonNegative, "N m", "friction torque of a drum that turns", 0.0),
    COULOMB_SPEED,
)

DRUM = Winch(
    header="cdpr/cables/drum/drum.hpp",
    numbers=NUMBERS,
    transmission=TRANSMISSION,
    states=COORDINATE,
    needs=of_winch(),
)
