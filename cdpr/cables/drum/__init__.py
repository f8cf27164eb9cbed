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

from collections.abc import Sequence

from cdpr.cables.chain import Winch
from cdpr.errors import CdprError
from cdpr.model import Cable


def numbers(cable: Cable) -> Sequence[float]:
    """Return radius, inertia, and the three numbers of friction."""
    winch = cable.winch
    if winch is None:
        raise CdprError(f"cable '{cable.name}' has no winch, which its cable model needs")
    return (
        winch.drum_radius,
        winch.inertia,
        winch.viscous_friction,
        winch.coulomb_friction,
        winch.coulomb_speed,
    )


DRUM = Winch(needs=("winch",), kernels="cdpr.cables.drum.kernels", numbers=numbers)
