"""Cable that stretches along its chord.

Of the length l (m) the part l0 is unwound. The tension is E A (l - l0) / l0 + d (l' - l0') if the cable is stretched, l
> l0, and at least 0; a slack cable has none. Rigid legs (`unilateral: false`) may also push.

When a cable becomes taut, its tension jumps by d l'; without damping, and when it becomes slack, the slope changes. No
fixed step ends exactly there, so that `reference` is of first order in the step after a jump and of second order after
a kink, instead of fourth. Engines are of first order anyway. The stiffness converts their position error, half a step's
travel or more, into a tension: E A / l0 times v h / 2, which at 1 ms may be some percent of a hard impact. Use a
shorter physics step if impacts matter.
"""

from __future__ import annotations

from cdpr.base.fields import NonNegative, Positive
from cdpr.base.needs import of_winch
from cdpr.cables.chain import Number, Span

AXIAL_STIFFNESS = Number("cable.axial_stiffness", Positive, "N", "axial stiffness, the product E A")
DAMPING = Number("cable.damping", NonNegative, "N s/m", "damping along the cable", 0.0)

ELASTIC = Span(header="cdpr/cables/elastic/elastic.hpp", numbers=(AXIAL_STIFFNESS, DAMPING), needs=of_winch())
