"""From the command of each cable to its tension: the cable models.

A winch winds its cable on a drum of radius r (m), which turns at w (rad/s), positive where it winds in. The command u
(N) is the tension that the motor would hold at rest: its torque is r u. Friction takes f(w) = b w + c tanh(w / w_c) of
it (N m), viscous and Coulomb's, the latter smoothed about rest. With I the inertia about the drum's axis (kg m^2):

    I w' = r u - f(w) - r T

- `ideal`: T = u. No winch takes part.
- `rigid`: the cable does not stretch, so the drum goes with the cable, l' = -r w, and
  T = u - f(-l'/r) / r + (I / r^2) l''. Since l' = -W^T twist, the inertias of the drums add to the platform's:
  (M + W m W^T) twist' = W (u - f/r - m W'^T twist) + everything else, m = diag(I / r^2). Thesis 2.20-2.24,
  but for the sign of 2.21: where a drum turns positively as it winds in, as in 2.20, q' = -R^-1 J x'; as printed, the
  drums' inertia would be subtracted. A cable that would have to push hangs slack, and its drum takes up what it leaves.
- `elastic`: two states a cable, the unstretched length l0 (m) between drum and platform, l0' = -r w, and w. The tension
  is E A (l - l0) / l0 + d (l' - l0') where the cable is stretched, l > l0, and at least 0; a slack cable has none. It
  starts with the tension that is commanded first, winding as fast as the length changes.

Rigid legs (`unilateral: false`) may also push: nothing is cut off at 0. All of it is evaluated wherever the integrator
evaluates the acceleration: once a step in semi-implicit engines, which then advance w and after it l0, and at every
stage of `reference`.

Where an elastic cable is pulled tight, its tension sets in with d l', a jump; without damping, and where it goes slack,
its slope changes. No fixed step ends just there, so that after a jump `reference` is of first order in the step and
after a kink of second, instead of fourth. Engines are of first order anyway; what they are off by in position, half a
step's travel or more, the stiffness turns into a tension: E A / l0 times v h / 2, which at 1 ms may be some percent of
a hard impact. Where impacts matter, take a shorter physics step.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cdpr.cables.point import Point
from cdpr.cables.pulley import Pulley

__all__ = ["AnyExit", "Point", "Pulley"]

# Where a cable leaves the frame. To add one, write its file (see `cdpr.cables.exit`) and name it here.
AnyExit = Annotated[Point | Pulley, Field(discriminator="type")]
