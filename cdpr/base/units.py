"""Units by name, for FMUs that do not define theirs and for scenarios with `unit: mm/s` or `mass: 25 kg`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """Unit defined by an FMU or by its name: SI value = value * factor + offset."""

    name: str
    exponents: tuple[int, ...] | None = None  # of BASE_UNITS; None if the FMU names a unit without definition
    factor: float = 1.0
    offset: float = 0.0


# Name -> nonzero exponents of BASE_UNITS, factor to SI.
KNOWN: dict[str, tuple[dict[str, int], float]] = {
    "1": ({}, 1.0), "-": ({}, 1.0), "%": ({}, 0.01),
    "m": ({"m": 1}, 1.0), "km": ({"m": 1}, 1e3), "cm": ({"m": 1}, 1e-2), "mm": ({"m": 1}, 1e-3),
    "um": ({"m": 1}, 1e-6),
    "s": ({"s": 1}, 1.0), "ms": ({"s": 1}, 1e-3), "min": ({"s": 1}, 60.0), "h": ({"s": 1}, 3600.0),
    "kg": ({"kg": 1}, 1.0), "g": ({"kg": 1}, 1e-3), "t": ({"kg": 1}, 1e3),
    "rad": ({"rad": 1}, 1.0), "mrad": ({"rad": 1}, 1e-3), "deg": ({"rad": 1}, math.pi / 180.0),
    "rev": ({"rad": 1}, 2.0 * math.pi), "rpm": ({"rad": 1, "s": -1}, 2.0 * math.pi / 60.0),
    "Hz": ({"s": -1}, 1.0),
    "N": ({"kg": 1, "m": 1, "s": -2}, 1.0), "kN": ({"kg": 1, "m": 1, "s": -2}, 1e3),
    "mN": ({"kg": 1, "m": 1, "s": -2}, 1e-3),
    "Nm": ({"kg": 1, "m": 2, "s": -2}, 1.0), "J": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "W": ({"kg": 1, "m": 2, "s": -3}, 1.0),
    "A": ({"A": 1}, 1.0), "mA": ({"A": 1}, 1e-3), "V": ({"kg": 1, "m": 2, "s": -3, "A": -1}, 1.0),
    "ohm": ({"kg": 1, "m": 2, "s": -3, "A": -2}, 1.0),
}  # fmt: skip
TOKEN = re.compile(r"\s*([/.*]?)\s*([^\W\d]+|1|-|%)(?:\^?\(?(-?[0-9])\)?)?\s*")
RAD = BASE_UNITS.index("rad")


def known_unit(text: str) -> Unit | None:
    """Return the unit of a text such as "N", "mm/s", "N.m" or "kg*m^2"; None if it is none."""
    exponents, factor, place = [0] * len(BASE_UNITS), 1.0, 0
    while place < len(text):
        match = TOKEN.match(text, place)
        if match is None or match[2] not in KNOWN or (place == 0 and match[1]):
            return None
        power = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        powers, scale = KNOWN[match[2]]
        for name, exponent in powers.items():
            exponents[BASE_UNITS.index(name)] += power * exponent
        factor *= scale**power
        place = match.end()
    return Unit(text, tuple(exponents), factor) if text and 0.0 < factor < math.inf else None


def si(text: str) -> Unit:
    """Return a unit written in the code of cdpr."""
    unit = known_unit(text)
    assert unit is not None
    return unit


def alike(a: Unit, b: Unit) -> bool:
    """Return True if two units measure the same kind of quantity; rad counts as 1, because some tools omit it."""
    assert a.exponents is not None
    assert b.exponents is not None
    return a.exponents[:RAD] == b.exponents[:RAD]
