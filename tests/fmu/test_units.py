"""Units by their names."""

from __future__ import annotations

import math

import pytest

from cdpr.base.units import BASE_UNITS, alike, known_unit, si

KNOWN = [
    ("N", "kg m s-2", 1.0), ("kN", "kg m s-2", 1e3), ("N.m", "kg m2 s-2", 1.0), ("N*m", "kg m2 s-2", 1.0),
    ("N m", "kg m2 s-2", 1.0), ("mm/s", "m s-1", 1e-3), ("m.s-1", "m s-1", 1.0), ("m/s^2", "m s-2", 1.0),
    ("m/s2", "m s-2", 1.0), ("m.s^(-2)", "m s-2", 1.0), ("1/s", "s-1", 1.0), ("deg", "rad", math.pi / 180),
    ("rev/min", "rad s-1", math.pi / 30), ("rpm", "rad s-1", math.pi / 30), ("N.m/rad", "kg m2 s-2 rad-1", 1.0),
    ("kg.cm2", "kg m2", 1e-4), ("1", "", 1.0), ("kg/kg", "", 1.0),
]  # fmt: skip


@pytest.mark.parametrize(("text", "exponents", "factor"), KNOWN)
def test_name_resolution(text, exponents, factor):
    unit = known_unit(text)
    expected = [0] * len(BASE_UNITS)
    for part in exponents.split():
        name = part.rstrip("-0123456789")
        expected[BASE_UNITS.index(name)] = int(part[len(name) :] or 1)
    assert unit.exponents == tuple(expected)
    assert unit.factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize("text", ["", " ", "/s", "m//s", "m.", "furlong", "N.furlong", "J/(kg.K)", "m^", "°", "N;rm"])
def test_unknown_units(text):
    assert known_unit(text) is None


def test_equal_measurements():
    assert alike(si("rad/s"), si("1/s"))  # some tools leave rad out
    assert alike(si("mm"), si("m"))
    assert not alike(si("N"), si("N.m"))
