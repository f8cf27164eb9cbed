"""Parts of cables as somebody would add them: a text and a header each, and the lines in the tables."""

RING = '''\
"""A ring that slides without friction on a straight rail: the cable is always square to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.needs import EVERYWHERE, Needs
from cdpr.cables.exit import Exit
from cdpr.base.fields import Vector3


class Ring(Exit):
    """A ring on a rail along x, y or z."""

    header: ClassVar[str] = "cdpr/cables/ring/ring.hpp"
    needs: ClassVar[Needs] = EVERYWHERE
    type: Literal["ring"] = Field(description="a ring that slides on a rail")
    rail: Vector3 = Field(description="direction of the rail, of length 1")

    def numbers(self) -> Sequence[float]:
        return self.rail

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        return [list(frame), list(leaving)]
'''

SPRING = '''\
"""A spring in each cable, of constant stiffness however much cable there is."""

from cdpr.base.needs import EVERYWHERE
from cdpr.cables.chain import Number, Span
from cdpr.base.fields import Positive

RATE = Number("cable.spring_rate", Positive, "N/m", "spring rate, force per stretch")
SPRING = Span(header="cdpr/cables/spring/spring.hpp", numbers=(RATE,), needs=EVERYWHERE)
'''

GEARED = '''\
"""A drum behind a gear without friction: the motor's tension is that of the command, times the ratio."""

from cdpr.base.needs import EVERYWHERE
from cdpr.cables.chain import Number, Winch
from cdpr.cables.drum import INERTIA, RADIUS
from cdpr.base.fields import Positive

RATIO = Number("winch.gear", Positive, "", "gear ratio")
GEARED = Winch(header="cdpr/cables/geared/geared.hpp", numbers=(RADIUS, INERTIA, RATIO), states=2, needs=EVERYWHERE)
'''

HEAVY = '''\
"""An elastic cable that sags a little, as a parabola: its chord's tension, and half of its weight at each end."""

from cdpr.base.needs import EVERYWHERE
from cdpr.cables.chain import LINEAR_DENSITY, Span
from cdpr.cables.elastic import AXIAL_STIFFNESS

NUMBERS = (AXIAL_STIFFNESS, LINEAR_DENSITY)
HEAVY = Span(header="cdpr/cables/heavy/heavy.hpp", numbers=NUMBERS, bends=True, needs=EVERYWHERE)
'''

HEADER = """\
#pragma once

#include <cdpr/cables/bent_cable.hpp>
#include <cdpr/cables/exit_result.hpp>
#include <cdpr/number.hpp>
#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {{

{code}
}}  // namespace cdpr::CDPR_TARGET
"""

HEADERS = {
    "ring": """\
struct Ring {
    template <class T> static CDPR_INLINE Vector<T> leave(Vector<T> anchor, const T* rail, Vector<T> tip) {
        return anchor + dot(vector(rail), tip - anchor) * vector(rail);
    }
    template <class T> static CDPR_INLINE ExitResult<T> lead(Vector<T> anchor, const T* rail, Vector<T> tip) {
        return {leave(anchor, rail, tip), 0.0};
    }
    template <class T> static CDPR_INLINE Vector<T> carry(const T* rail, Vector<T> V) {
        return dot(vector(rail), V) * vector(rail);
    }
};
""",
    "spring": """\
struct Spring {
    template <class T> static CDPR_INLINE T pull(const T* numbers, T length, T unwound, T lowest) {
        return larger(numbers[0] * (length - unwound), lowest);
    }
    template <class T> static CDPR_INLINE T rest(const T* numbers, T length, T tension) {
        return length - tension / numbers[0];
    }
};
""",
    "geared": """\
struct Geared {
    template <class T> static CDPR_INLINE WinchTension<T> held(const T* numbers, T command, T swing) {
        const T mass = numbers[1] / (numbers[0] * numbers[0]);
        return {numbers[2] * command + mass * swing, mass};
    }
    template <class T> static CDPR_INLINE T turn(const T* numbers, T command, T tension) {
        return numbers[0] * (numbers[2] * command - tension) / numbers[1];
    }
};
""",
    "heavy": """\
struct Heavy {
    template <class T> static CDPR_INLINE BentCable<T> pull(BentSpan<T> span, T unwound, T lowest) {
        const T reach = length(span.chord);
        const T along = larger(lowest, span.numbers[0] * (reach + span.wrapped_length - unwound) / unwound) / reach;
        const Vector<T> pulling = along * span.chord, down = T(0.5 * span.numbers[1] * unwound) * span.gravity;
        return {pulling + down, length(pulling - down)};
    }
    template <class T> static CDPR_INLINE T rest(BentSpan<T> span, T tension) {
        return (length(span.chord) + span.wrapped_length) / (1.0 + tension / span.numbers[0]);
    }
};
""",
}

# Text that follows certain words of parts.hpp.
IN_THE_HEADER = {
    "headers": (
        "".join(f"#include <cdpr/cables/{name}/{name}.hpp>\n" for name in HEADERS),
        "#include <cdpr/cables/pulley/pulley.hpp>\n",
    ),
    "exits": (", RING", "POINT, PULLEY"),
    "winches": (", GEARED", "DIRECT, DRUM"),
    "spans": (", SPRING, HEAVY", "INEXTENSIBLE, ELASTIC, CATENARY, TABULATED, VISCOELASTIC"),
    "leave": (
        "\n    if (is(kind, RING)) return Ring::leave(anchor, numbers, tip);",
        "Pulley::leave(anchor, numbers, tip);",
    ),
    "lead": (
        "\n    if (is(kind, RING)) return Ring::lead(anchor, numbers, tip);",
        "Pulley::lead(anchor, numbers, tip);",
    ),
    "carry": ("\n    if (is(kind, RING)) return Ring::carry(numbers, V);", "Pulley::carry(anchor, numbers, tip, V);"),
    "held": (
        "\n    if (is(kind, GEARED)) return Geared::held(numbers, command, length_acceleration);",
        "Drum::held(numbers, command, rate, length_acceleration);",
    ),
    "turn": (
        "\n    if (is(kind, GEARED)) return Geared::turn(numbers, command, tension);",
        "Drum::drum_acceleration(numbers, command, tension, speed);",
    ),
    "pull": (
        "\n    if (is(kind, SPRING)) return Spring::pull(numbers, length, unwound, lowest);",
        "Elastic::pull(numbers, length, unwound, stretching, lowest);",
    ),
    "rest": (
        "\n    if (is(kind, SPRING)) return Spring::rest(numbers, length, tension);",
        "Elastic::rest(numbers, length, tension);",
    ),
    "bends": (" if (is(kind, HEAVY)) return true;", "bool bends(T kind) {"),
    "bent_pull": (
        "\n    if (is(kind, HEAVY)) return Heavy::pull(span, unwound, lowest);",
        "Catenary::pull(span, unwound, stretching, lowest);",
    ),
    "bent_rest": (
        "\n    if (is(kind, HEAVY)) return Heavy::rest(span, tension);",
        "Catenary::rest(span, tension);",
    ),
}

PARTS = {
    "ring": RING,
    "spring": SPRING,
    "geared": GEARED,
    "heavy": HEAVY,
}
IMPORTS = {
    "spring": ("from cdpr.cables.spring import SPRING\n", "from cdpr.cables.inextensible import INEXTENSIBLE\n"),
    "geared": ("from cdpr.cables.geared import GEARED\n", "from cdpr.cables.elastic import ELASTIC\n"),
    "heavy": ("from cdpr.cables.heavy import HEAVY\n", "from cdpr.cables.exit import Exit\n"),
}
ENTRIES = {
    "ring_named": (', "ring": "cdpr.cables.ring:Ring"', '"pulley": "cdpr.cables.pulley:Pulley"'),
    "models": (
        '    "sprung": Chain(DRUM, SPRING),\n    "geared": Chain(GEARED, SPRING),\n    "heavy": Chain(DRUM, HEAVY),\n',
        '    "viscoelastic": Chain(DRUM, VISCOELASTIC),\n',
    ),
}
