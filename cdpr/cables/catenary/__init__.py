"""Elastic, heavy cable: the catenary of Irvine, from taut to fully slack.

Of the cable the length U (m) is unwound. A part of it, b (m) when stretched, lies on the exit; the rest, L, hangs
between the exit and the platform, which are l (m) apart horizontally and z (m) vertically. The cable weighs w = (mass
per length) g per unstretched length, stretches by T / EA, and is in equilibrium at every moment: it has no waves. With
H the horizontal force, V_0 and V_1 = V_0 + w L the vertical ones, T_0 and T_1 the tensions at platform and exit,
Irvine, Cable Structures (1981), section 1.4, is

    l = H L / EA + (H / w) (asinh(V_1 / H) - asinh(V_0 / H)),
    z = (V_0 + V_1) L / (2 EA) + (T_1 - T_0) / w.

With S = T_0 + T_1, a = S / (2 EA), x = w L / S and q = atanh(x) / x, the same is

    H = l S / (2 L (q + a)),   (V_0 + V_1) / 2 = z S / (2 L (1 + a)),
    z^2 / (L (1 + a))^2 + l^2 / ((L (q + a))^2 (1 - x^2)) = 1,

which has one solution S > w L, as its left side falls with S. This form subtracts no nearly equal numbers. Without
weight it is the cable `elastic`.

- **Winch.** T_1 is the tension at the exit. On a pulley without friction, T + T^2 / (2 EA) grows by w per metre of
  height; the winch has the tension where the cable arrives at the pulley. The part on it stretches by a, so L = U - b /
  (1 + a).
- **Least tension.** T_1 = S / 2 + w z / (2 (1 + a)) does not depend on L: S follows from the tension at the winch. A
  heavy cable has a least one, and above it two lengths, of a taut and of a slack cable. Commands and starts mean the
  taut one. At the slack one a longer cable has a higher tension at the winch, which then unwinds for ever.
- **Damping.** A damper d (N s/m) along the chord acts on the part of its change that stretches the cable: the force d s
  (l' - U'), with l' the rate of the cable's length, and s = (L / EA) d(S / 2) / d(chord) at constant L, which is 1 for
  a taut cable without weight and 0 for a slack one. It never exceeds the pull of the cable along the chord.
- **Limits.** Cables that push (`unilateral: false`) have no catenary.
"""

from __future__ import annotations

from cdpr.base.needs import of_winch
from cdpr.cables.chain import LINEAR_DENSITY, Span
from cdpr.cables.elastic import AXIAL_STIFFNESS, DAMPING

CATENARY = Span(
    header="cdpr/cables/catenary/catenary.hpp",
    numbers=(AXIAL_STIFFNESS, LINEAR_DENSITY, DAMPING),
    bends=True,
    needs=of_winch(),
)
