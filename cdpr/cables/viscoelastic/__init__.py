"""Cable that creeps under load, with hysteresis.

Fibre ropes become longer under a constant load, recover when it is removed, and follow another curve when unloaded. Of
the length l (m) the part l0 is unwound; the strain is e = (l - l0) / l0. The tension is T = Q + H + d (l' - l0').

Creep: Q = E A (e - c_1 - c_2 - c_3) is the tension of a spring in series with up to three elements of Kelvin and
Voigt, c_k' = (phi_k Q / (E A) - c_k) / tau_k, a Prony series of the compliance. Under a constant tension the strain is
Q / (E A) (1 + sum of phi_k (1 - exp(-t / tau_k))). Piao et al. (2017), "Open-loop position control of a polymer
cable-driven parallel robot via a viscoelastic cable model for high payload workspaces", use two elements for the
polymer cables of a robot; phi_k is the stiffness of the spring divided by that of the element.

Hysteresis: H = K (e - p) is a spring K in series with a slip p, p' = e' |H| / S while the strain changes in the
direction of H, otherwise p' = 0. This is the model of Bouc (1967) and Wen (1976), H' = K e' - (|e'| H + e' |H|) K / (2
S), with A = 1, beta = gamma = 1/2 and n = 1, with an internal variable. Miyasaka et al. (2016), "Hysteresis model of
longitudinally loaded cable for cable driven robots and identification of the parameters", use Bouc and Wen's model for
the steel cables of robots. It does not depend on the speed. After a reversal, H approaches S over strains of the size
S / K. A loop between strains +-a far above S / K loses about 4 S a of energy per unwound length. The stiffness of a
small reversal is E A + K.

A slack cable, with Q + H at most 0, has no tension: its creep recovers, and its slip rests. The strains are those of
the whole unwound length: cable that the drum pays out has crept as much as the cable in use.

At the start of a run, the creep has progressed by a share `creep_progress` of its end under the first tension: 0 for a
new cable, 1 for one that has had its load for a long time. The hysteresis begins in the middle of its loop. Equilibria,
flex compensation, and the nominal cables of controllers use the lengths at this progress, without hysteresis. The
stiffness is that of small and quick motions, without creep, with the hysteresis of a small reversal.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cdpr.base.errors import CdprError
from cdpr.base.fields import NonNegative, Positive, Share
from cdpr.base.needs import of_winch
from cdpr.cables.chain import Number, Span, Table
from cdpr.cables.elastic import AXIAL_STIFFNESS, DAMPING
from cdpr.model import Cable
from cdpr.model.robot import Array

ELEMENTS = 3  # as in viscoelastic.hpp

KEY = "creep"
COEFFICIENTS, TIMES = (
    tuple(
        Number(
            f"cable.creep_{key}_{k}", NonNegative, unit, f"creep, {text} of element {k}, 0 without it", 0.0, table=KEY
        )
        for k in range(1, ELEMENTS + 1)
    )
    for key, unit, text in (
        ("coefficient", "", "strain of creep per elastic strain"),
        ("time", "s", "retardation time"),
    )
)
CREEP = Table(
    KEY,
    Annotated[list[tuple[Positive, Positive]], Field(min_length=1, max_length=ELEMENTS)],
    "creep coefficients (strain of creep per elastic strain) and retardation times (s) of up to three elements, with "
    "cable.model: viscoelastic",
    (COEFFICIENTS, TIMES),
)
STIFFNESS = Number(
    "cable.hysteresis_stiffness", NonNegative, "N", "stiffness of the hysteresis, added to E A after a reversal", 0.0
)
TENSION = Number("cable.hysteresis_tension", NonNegative, "N", "largest tension of the hysteresis", 0.0)
PROGRESS = Number(
    "cable.creep_progress", Share, "", "share of the creep that has taken place at the start and at rest", 0.0
)


class Viscoelastic(Span):
    """Span with creep and hysteresis."""

    def values(self, cable: Cable) -> list[float]:
        """Return its numbers for a cable, in order.

        Raises:
            CdprError: if the cable lacks one, or has one number of the hysteresis only.
        """
        found = super().values(cable)
        stiffness, tension = STIFFNESS.of(cable), TENSION.of(cable)
        if (stiffness > 0.0) != (tension > 0.0):
            given, lacking = (STIFFNESS, TENSION) if stiffness > 0.0 else (TENSION, STIFFNESS)
            raise CdprError(
                f"cable '{cable.name}': {given.key} needs {lacking.key}: set both for hysteresis, or neither"
            )
        return found

    def stiffest(self, cable: Cable) -> float:
        """Return the axial stiffness after a reversal, N."""
        return AXIAL_STIFFNESS.of(cable) + STIFFNESS.of(cable)

    def tangent(self, cable: Cable, tension: Array) -> Array:
        """Return (1 + e) (E A + K) - T, N, at the strains e of tensions (k,), N."""
        crept = 1.0 + PROGRESS.of(cable) * sum(number.of(cable) for number in COEFFICIENTS)
        strain = tension * crept / AXIAL_STIFFNESS.of(cable)
        return (1.0 + strain) * self.stiffest(cable) - tension

    def shortest_time(self, cable: Cable) -> float:
        """Return the shortest time in which its tension relaxes at a constant length, s."""
        coefficients, times = ([number.of(cable) for number in numbers] for numbers in (COEFFICIENTS, TIMES))
        return min((time for time in times if time > 0.0), default=float("inf")) / (1.0 + sum(coefficients))

    def nonlinear(self, cable: Cable) -> str:
        """Return a reason for a cable with hysteresis."""
        if not STIFFNESS.of(cable):
            return ""
        return "hysteresis of cables is not linear; for poles without it, set its stiffness and its tension to 0"


VISCOELASTIC = Viscoelastic(
    header="cdpr/cables/viscoelastic/viscoelastic.hpp",
    numbers=(AXIAL_STIFFNESS, DAMPING, *COEFFICIENTS, *TIMES, STIFFNESS, TENSION, PROGRESS),
    needs=of_winch(),
    states=ELEMENTS + 1,
)
