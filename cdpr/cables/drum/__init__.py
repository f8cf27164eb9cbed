"""A motor that winds the cable on a drum.

The drum of radius r (m) turns at w (rad/s), positive where it winds in. The command u (N) is the tension that the motor
would hold at rest: its torque is r u. Friction takes f(w) = b w + c tanh(w / w_c) of it (N m), viscous and Coulomb's,
the latter smoothed about rest. With I the inertia about the drum's axis (kg m^2):

    I w' = r u - f(w) - r T

Where the cable does not stretch, l' = -r w, and T = u - f(-l'/r) / r + (I / r^2) l''. Thesis 2.20-2.24, but for the
sign of 2.21: where a drum turns positively as it winds in, as in 2.20, q' = -R^-1 J x'; as printed, the drums' inertia
would be subtracted.
"""

from __future__ import annotations

from cdpr.cables.chain import Number, Winch

NUMBERS = (
    Number("winch.drum_radius", "m", "radius of the drum", positive=True),
    Number("winch.inertia", "kg.m2", "inertia of motor and drum about the drum's axis", positive=True),
    Number("winch.viscous_friction", "N.m.s/rad", "friction torque per drum speed"),
    Number("winch.coulomb_friction", "N.m", "friction torque of a drum that turns"),
    Number("winch.coulomb_speed", "rad/s", "drum speed at which that reaches 76 % of its value", positive=True),
)

DRUM = Winch(needs=("winch",), kernels="cdpr.cables.drum.kernels", numbers=NUMBERS)
