"""Declarations of winches and spans, and the chains of parts of cables.

From the drum to the platform, a cable is a winch, an exit (see `cdpr.cables.exit`) and a span. If the span does not
stretch, the drum moves with the cable: the winch provides the tension without the effect of its inertia when the
platform accelerates, and that inertia as a mass along the cable. The platform is solved with these masses, (M + sum m_i
w_i w_i^T) twist' = ..., with w_i the cable's column of W, and they take their part of the tension. A span that
stretches defines the tension itself, from the cable's length and the unwound length; the winch then turns under it. A
span that bends, such as a heavy cable, also defines the force on the platform, which is not along the chord. Per unit
of the winch's coordinate, the unwound length changes by the first of the winch's numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.fields import AtLeastOne, Efficiency, NonNegative, Positive, Section
from cdpr.base.needs import Needs
from cdpr.base.problems import short_repr
from cdpr.base.units import known_unit
from cdpr.model import Cable
from cdpr.model.robot import Array

MOST = 12  # maximum numbers of a part, as in chain.hpp
COORDINATE = 2  # states of a winch that turns: unwound length, and speed of its coordinate
MOST_STATES = 16  # maximum states of a winch, as in winch_tension.hpp
MOST_SPAN_STATES = 4  # maximum states of a span, as in span_motion.hpp

# Reserved keys of robot files and names in `cdpr.model`, which are no numbers of parts; attributes of sections are
# reserved, too.
TAKEN = {
    "cable": (
        *("name", "frame", "platform", "tension", "tension_min", "tension_max", "length", "length_min", "length_max"),
        *("speed_max", "winch", "exit", "model", "own", "stiffness_table", "creep"),
    ),
    "winch": ("build", "own", "type"),
}


@dataclass(frozen=True)
class Number:
    """Number of a cable that the kernels of its part use, with its complete definition.

    Attributes:
        name: place in robot files, "cable" or "winch", and key; exported FMUs use it as the name of a parameter.
        kind: type of its values, from `cdpr.base.fields`.
        unit: as in robot files, "" without unit.
        text: description; up to the first comma, after "the", it names what a cable lacks.
        default: default value; None if the part requires one.
        exact: unit as in FMUs, if more precise.
        table: key of the table in robot files that contains it; "" for a key of its own.
    """

    name: str
    kind: Any
    unit: str
    text: str
    default: float | None = None
    exact: str = ""
    table: str = ""

    def __post_init__(self) -> None:
        """Raise CdprError for values that robot files and FMUs do not support."""
        if self.owner not in ("cable", "winch") or not self.key.isidentifier() or self.key[0] == "_":
            raise CdprError(f"expected a name such as cable.KEY or winch.KEY, got {self.name}")
        unit = known_unit(self.unit_of_fmu) if self.unit else None
        if self.unit and (unit is None or unit.factor != 1.0):
            found = "is not known: see cdpr.base.units" if unit is None else "is no SI unit: kernels take those"
            raise CdprError(f"{self.name}: the unit {self.unit_of_fmu} {found}")

    @property
    def owner(self) -> str:
        """Place, "cable" or "winch"."""
        return self.name.partition(".")[0]

    @property
    def key(self) -> str:
        """Key at that place."""
        return self.name.partition(".")[2]

    @property
    def file_key(self) -> str:
        """Key at that place in robot files."""
        return self.table or self.key

    @property
    def positive(self) -> bool:
        """True if it must be greater than 0."""
        return self.kind in (Positive, Efficiency, AtLeastOne)

    @property
    def unit_of_fmu(self) -> str:
        """Unit as in FMUs."""
        return self.exact or self.unit.replace(" ", ".").replace("^", "")

    def of(self, cable: Cable, without: float | None = None) -> float:
        """Return the value for a cable; `without` if it has none and there is no default.

        Raises:
            CdprError: if the cable has none.
        """
        holder = cable if self.owner == "cable" else cable.winch
        value = None if holder is None else getattr(holder, self.key, holder.own.get(self.key))
        if value is None:
            value = None if holder is None else self.default
        if value is None or math.isnan(value):
            if without is not None:
                return without
            lacking = self.owner if holder is None else self.file_key
            raise CdprError(f"cable '{cable.name}' has no {lacking}, which its cable model needs")
        return float(value)


@dataclass(frozen=True)
class Table:
    """Numbers of a cable that robot files give as a list of rows.

    Attributes:
        key: key of the list.
        kind: type of its value.
        text: description.
        columns: numbers of each column, row by row; the first one is positive in each row that the list contains.
    """

    key: str
    kind: Any
    text: str
    columns: tuple[tuple[Number, ...], ...]

    def numbers(self, rows: Sequence[Sequence[float]]) -> dict[str, float]:
        """Return the numbers of a cable with these rows, by key."""
        return {
            number.key: float(value)
            for row, numbers in zip(rows, zip(*self.columns, strict=True), strict=False)
            for number, value in zip(numbers, row, strict=True)
        }

    def rows(self, own: Mapping[str, float]) -> list[tuple[float, ...]]:
        """Return the rows from a cable's numbers, by key; [] without any."""
        rows = [tuple(own.get(number.key, 0.0) for number in row) for row in zip(*self.columns, strict=True)]
        return [row for row in rows if row[0] > 0.0]


# Numbers of any cable, independent of its parts.
DIAMETER = Number("cable.diameter", Positive, "m", "diameter")
LINEAR_DENSITY = Number("cable.linear_density", NonNegative, "kg/m", "mass per length")


@dataclass(frozen=True)
class Part:
    """Winch or span.

    Attributes:
        header: header of its kernel, included by `cdpr/cables/parts.hpp`; "" if it needs none.
        numbers: numbers of a cable that its kernel uses, at most MOST, in order.
        needs: support that it needs; None, which every use of a scenario rejects, if nobody has thought of it.
        without: values of numbers that a cable need not have, by name.

    Raises:
        CdprError: if it has more numbers than its row holds, or one with a reserved name.
    """

    header: str = ""
    numbers: tuple[Number, ...] = ()
    needs: Needs | None = None
    without: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        """Raise CdprError for numbers that its row or robot files do not support."""
        for number in self.numbers:
            if number.key in TAKEN[number.owner] or hasattr(Section, number.key):
                taken = sorted({*TAKEN[number.owner], *(name for name in dir(Section) if name[0] != "_")})
                raise CdprError(
                    f"{self.header or 'a part of a cable'}: its number {number.name} has a reserved name; reserved "
                    f"names: {', '.join(taken)}"
                )
        if len(self.numbers) > MOST:
            raise CdprError(f"a part of a cable takes {MOST} numbers at most, not {len(self.numbers)}")

    @property
    def required(self) -> tuple[Number, ...]:
        """Numbers that each cable must have, or that have a default."""
        return tuple(number for number in self.numbers if number.name not in self.without)

    def values(self, cable: Cable) -> list[float]:
        """Return its numbers for a cable, in order.

        Raises:
            CdprError: if the cable lacks one.
        """
        return [number.of(cable, self.without.get(number.name)) for number in self.numbers]


@dataclass(frozen=True)
class Winch(Part):
    """Part that converts a command into a tension or a motion.

    Its kernel is a struct of templates over the number type T (`cdpr/cables/drum/drum.hpp`). `held(numbers, command,
    rate, length_acceleration)` returns tension, N, and mass, kg, of a cable whose length changes by `rate`, m/s, and
    would change by `length_acceleration`, m/s^2, if the platform did not accelerate. `drum_acceleration(numbers,
    command, tension, speed)` returns the acceleration of a winch that pulls with `tension`.

    A winch that turns has the states unwound length, m, and speed of its coordinate, positive when winding in. If the
    span does not stretch, they follow the cable and are no states. Further states are the winch's own, such as the
    torque of a motor with a lag: `cdpr/cables/parts.hpp` then passes them to these two functions, and calls two more.
    `own_start(motion, own)` writes them at the start, at which the cable pulls with the command; `own_slopes(motion,
    slope)` writes their time derivatives. `motion` is a `WinchMotion`. The check of the physics step does not include
    them, and is omitted for winches without the numbers `drum_radius` and `inertia` (`cdpr.mechanics.stability`).

    A winch that turns may accept the numbers of `cdpr.cables.transmission`. Its kernel then needs nothing more: its
    first number is the present cable per unit of its coordinate, and tensions and masses include the losses.

    Attributes:
        command: quantity that its kernel takes as its command: a tension, N, the unwound length, m, or its rate, m/s.
            A length or a rate requires a span that stretches.
        immediate: True if its tension always equals the command.
        states: number of its states, at most MOST_STATES: 0, or COORDINATE and the number of its own.
        transmission: accepted numbers of `cdpr.cables.transmission`.

    Raises:
        CdprError: for another number of states, or an immediate winch with states.
    """

    command: Literal["tension", "length", "rate"] = "tension"
    immediate: bool = False
    states: int = 0
    transmission: tuple[Number, ...] = ()

    @property
    def accepted(self) -> tuple[Number, ...]:
        """Numbers of the winch and its transmission."""
        return (*self.numbers, *self.transmission)

    def __post_init__(self) -> None:
        """Raise CdprError for numbers or states that the kernels do not support."""
        super().__post_init__()
        name = self.header or "a winch"
        if type(self.states) is not int or (self.states != 0 and not COORDINATE <= self.states <= MOST_STATES):
            raise CdprError(
                f"{name}: states: expected 0, or {COORDINATE} to {MOST_STATES}, got {short_repr(self.states)}"
            )
        if self.immediate and self.states:
            raise CdprError(f"{name}: an immediate winch has no states: set states=0, or immediate=False")


@dataclass(frozen=True)
class Span(Part):
    """Part from the exit to the platform.

    Kernel of a span that stretches (`cdpr/cables/elastic/elastic.hpp`): `pull(numbers, length, unwound, stretching,
    lowest)` returns the tension, N, not below `lowest`, of a cable with this length and unwound length, m, and this
    stretching rate, m/s; `rest(numbers, length, tension)` returns the unwound length at this tension. A span without a
    header does not stretch.

    Kernel of a span with states (`cdpr/cables/viscoelastic/viscoelastic.hpp`): `pull(motion, lowest)` takes a
    `SpanMotion` with its states, and `pull_at_rest` those of a cable at rest. `start` writes the states at the start,
    `slopes` their time derivatives.

    Kernel of a span that bends: in place of the length it takes a `BentSpan` (chord, m, from the platform to the exit,
    world axes; length of cable on the exit, m; gravity, m/s^2). `pull(span, unwound, lowest)` returns the force on the
    platform and the tension at the winch, N; `rest(span, tension)` is as above. Equilibria and stiffness also need its
    derivatives and its energy, `bent_rates` and `bent_energy` in `cdpr/cables/parts.hpp`: without them they are NaN.

    Attributes:
        bends: True if its force on the platform may differ in direction from the chord.
        states: number of its states, at most MOST_SPAN_STATES; of a span that stretches along its chord.

    Raises:
        CdprError: for another number of states.
    """

    bends: bool = False
    states: int = 0

    def __post_init__(self) -> None:
        """Raise CdprError for numbers or states that the kernels do not support."""
        super().__post_init__()
        most = MOST_SPAN_STATES if self.header and not self.bends else 0
        if type(self.states) is not int or not 0 <= self.states <= most:
            raise CdprError(f"{self.header or 'a span'}: states: expected 0 to {most}, got {short_repr(self.states)}")

    def stiffest(self, cable: Cable) -> float:
        """Return the largest axial stiffness of a cable under any tension, N; 0 if it is not known."""
        return cable.axial_stiffness or 0.0

    def tangent(self, cable: Cable, tension: Array) -> Array:
        """Return the axial stiffness of the elastic cables whose tension changes alike with their length.

        Args:
            cable: the cable.
            tension: (k,) N.

        Returns:
            (k,) N; 0 if it is not known.
        """
        return np.full(len(tension), cable.axial_stiffness or 0.0)

    def shortest_time(self, cable: Cable) -> float:
        """Return the shortest time constant of its states, s; infinite without any."""
        return math.inf

    def nonlinear(self, cable: Cable) -> str:
        """Return the reason why a loop with this cable has no linearisation at rest; "" if it has one."""
        return ""


@dataclass(frozen=True)
class Chain:
    """Winch and span of a cable.

    Raises:
        CdprError: for a span that stretches on a winch that does not turn.
    """

    winch: Winch
    span: Span

    def __post_init__(self) -> None:
        """Raise CdprError if the span needs states that the winch does not have."""
        if self.stretches and not self.winch.states:
            raise CdprError(
                f"{self.span.header}: a span that stretches needs a winch with the states unwound length and speed: "
                f"declare states={COORDINATE} or more in the winch"
            )

    @property
    def numbers(self) -> tuple[Number, ...]:
        """Numbers of winch, transmission and span."""
        return (*self.winch.accepted, *self.span.numbers)

    @property
    def states(self) -> int:
        """Number of states: those of the span and of the winch, without its coordinate if that follows the cable."""
        winch = self.winch.states if self.stretches else max(self.winch.states - COORDINATE, 0)
        return winch + self.span.states

    @property
    def stretches(self) -> bool:
        """True if the unwound length is a state."""
        return bool(self.span.header)

    @property
    def immediate(self) -> bool:
        """True if its tension equals the command."""
        return self.winch.immediate
