"""A cable that stretches along its chord.

Of the length l (m) the part l0 has been unwound. The tension is E A (l - l0) / l0 + d (l' - l0') where the cable is
stretched, l > l0, and at least 0; a slack cable has none. Rigid legs (`unilateral: false`) may also push.

Where it is pulled tight, its tension sets in with d l', a jump; without damping, and where it goes slack, its slope
changes. No fixed step ends just there, so that after a jump `reference` is of first order in the step and after a kink
of second, instead of fourth. Engines are of first order anyway; what they are off by in position, half a step's travel
or more, the stiffness turns into a tension: E A / l0 times v h / 2, which at 1 ms may be some percent of a hard impact.
Where impacts matter, take a shorter physics step.
"""

from __future__ import annotations

from cdpr.cables.chain import Number, Span
from cdpr.fields import NonNegative, Positive

AXIAL_STIFFNESS = Number("cable.axial_stiffness", Positive, "N", "axial stiffness, the product E A")
DAMPING = Number("cable.damping", NonNegative, "N s/m", "damping along the cable", 0.0)

ELASTIC = Span(header="cdpr/cables/elastic/elastic.hpp", numbers=(AXIAL_STIFFNESS, DAMPING))
