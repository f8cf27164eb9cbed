"""What winches and spans declare, and the chains that cables are made of.

From the drum to the platform a cable is a winch, an exit (see `cdpr.cables.exit`) and a span. Where the span does not
stretch, the drum goes with the cable: the winch tells the tension, free of what its inertia takes when the platform
accelerates, and that inertia as a mass along the cable. The platform is solved for with these masses,
(M + sum m_i w_i w_i^T) twist' = ..., w_i the cable's column of W, and they take their part of the tension. A span that
stretches makes the tension itself, from the cable's length and how much of it has been unwound; the winch then turns
under it. One that bends, as a heavy cable does, also makes the force on the platform, which is then not along the
chord. The unwound length changes by the first of the winch's numbers for each unit by which its coordinate turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from cdpr.errors import CdprError
from cdpr.fields import NonNegative, Positive, Section
from cdpr.model import Cable
from cdpr.units import known_unit

MOST = 8  # numbers that a part may have

# Keys of robot files, and names in `cdpr.model`, that are no number of a part; what sections can do is taken, too.
TAKEN = {
    "cable": (
        *("name", "frame", "platform", "tension", "tension_min", "tension_max", "length", "length_min", "length_max"),
        *("speed_max", "winch", "exit", "model", "own"),
    ),
    "winch": ("build", "own"),
}


@dataclass(frozen=True)
class Number:
    """A number of a cable that the kernels of its part take, and all that is said of it: this is its one place.

    Attributes:
        name: where a robot says it of all cables, "cable" or "winch" and its key; an exported FMU calls its parameter
            so, and the cable has it under the key.
        kind: which values it may have, of `cdpr.fields`.
        unit: as robot files write it, "" of what has none.
        text: what it is; as far as the first comma, after "the", what a cable lacks that has none.
        default: where none is given; None where the part needs one.
        exact: the unit as FMUs write it, where that says more.
    """

    name: str
    kind: Any
    unit: str
    text: str
    default: float | None = None
    exact: str = ""

    def __post_init__(self) -> None:
        """Refuse what robot files and FMUs cannot hold; CdprError."""
        if self.owner not in ("cable", "winch") or not self.key.isidentifier() or self.key[0] == "_":
            raise CdprError(f"a number of a cable is called cable.KEY or winch.KEY, not {self.name}")
        unit = known_unit(self.unit_of_fmu) if self.unit else None
        if self.unit and (unit is None or unit.factor != 1.0):
            found = "is not known: see cdpr.units" if unit is None else "is no SI unit: kernels take those"
            raise CdprError(f"{self.name}: the unit {self.unit_of_fmu} {found}")

    @property
    def owner(self) -> str:
        """Where it stands, "cable" or "winch"."""
        return self.name.partition(".")[0]

    @property
    def key(self) -> str:
        """Its name there."""
        return self.name.partition(".")[2]

    @property
    def positive(self) -> bool:
        """Whether it must be greater than 0."""
        return self.kind is Positive

    @property
    def unit_of_fmu(self) -> str:
        """Its unit as FMUs write it."""
        return self.exact or self.unit.replace(" ", ".").replace("^", "")

    def of(self, cable: Cable) -> float:
        """Return it; CdprError where the cable has none."""
        holder = cable if self.owner == "cable" else cable.winch
        value = None if holder is None else getattr(holder, self.key, holder.own.get(self.key))
        if value is None:
            value = None if holder is None else self.default
        if value is None or math.isnan(value):
            lacking = self.owner if holder is None else self.key
            raise CdprError(f"cable '{cable.name}' has no {lacking}, which its cable model needs")
        return float(value)


# What is known of any cable, whatever its parts take of it.
DIAMETER = Number("cable.diameter", Positive, "m", "diameter")
LINEAR_DENSITY = Number("cable.linear_density", NonNegative, "kg/m", "mass per length")


@dataclass(frozen=True)
class Part:
    """A winch or a span.

    CdprError where it has more numbers than its row holds, or one whose name is taken.

    Attributes:
        header: of its kernel, included by `cdpr/parts.hpp`; empty for one that has no need of any.
        numbers: what its kernel takes of a cable, at most MOST, in its order.
    """

    header: str = ""
    numbers: tuple[Number, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what neither its row nor robot files can hold; CdprError."""
        for number in self.numbers:
            if number.key in TAKEN[number.owner] or hasattr(Section, number.key):
                taken = sorted({*TAKEN[number.owner], *(name for name in dir(Section) if name[0] != "_")})
                raise CdprError(
                    f"{self.header or 'a part of a cable'}: its number {number.name} has a name that means something "
                    f"else; taken are {', '.join(taken)}: call it otherwise"
                )
        if len(self.numbers) > MOST:
            raise CdprError(f"a part of a cable takes {MOST} numbers at most, not {len(self.numbers)}")


@dataclass(frozen=True)
class Winch(Part):
    """Turns a command into a tension or a motion.

    Its kernel is a struct of templates over the number type T (`cdpr/cables/drum/drum.hpp`). `held(numbers, command,
    rate, length_acceleration)`: tension, N, and mass, kg, of a cable whose length changes by `rate`, m/s, and would by
    `length_acceleration`, m/s^2, if the platform did not accelerate. `drum_acceleration(numbers, command, tension,
    speed)`: change of the speed of a winch that pulls with `tension`.

    Attributes:
        immediate: whether its tension is the command, whatever else happens.
    """

    immediate: bool = False


@dataclass(frozen=True)
class Span(Part):
    """From the exit to the platform.

    The kernel of one that stretches (`cdpr/cables/elastic/elastic.hpp`): `pull(numbers, length, unwound, stretching,
    lowest)`, the tension, N, of a cable of this length of which so much, m, is unwound, when it stretches by so much a
    second, m/s, not below the lowest; `rest(numbers, length, tension)`, the unwound length at this tension. One
    without a header does not stretch.

    That of one that bends takes a `BentSpan` (chord, m, from the platform to the exit, world axes; length of cable on
    the exit, m; gravity, m/s^2) in place of the length: `pull(span, unwound, lowest)`, the force on the platform and
    the tension at the winch, N; `rest(span, tension)`.

    Attributes:
        bends: whether its force on the platform may have another direction than the chord.
    """

    bends: bool = False


@dataclass(frozen=True)
class Chain:
    """The winch and the span of a cable."""

    winch: Winch
    span: Span

    @property
    def numbers(self) -> tuple[Number, ...]:
        """What winch and span take of a cable."""
        return (*self.winch.numbers, *self.span.numbers)

    @property
    def stretches(self) -> bool:
        """Whether what is unwound is a state of its own."""
        return bool(self.span.header)

    @property
    def immediate(self) -> bool:
        """Whether its tension is the command."""
        return self.winch.immediate
