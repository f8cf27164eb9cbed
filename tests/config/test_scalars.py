"""Unquoted scalars of strict YAML 1.2."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdpr.config.scalars import resolve


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0", 0),
        ("-5", -5),
        ("+5", 5),
        ("1e-3", 0.001),
        (".5", 0.5),
        ("-.5", -0.5),
        ("1.", 1.0),
        ("1.5E+2", 150.0),
        ("true", True),
        ("false", False),
        ("null", None),
        ("~", None),
        ("", None),
    ],
)
def test_numbers_booleans_and_null(text, value):
    found = resolve(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    "text",
    [
        "no",
        "yes",
        "on",
        "off",
        "True",
        "FALSE",
        "Null",
        "NULL",
        "y",
        "n",
        "010",
        "00",
        "-01",
        "1:30",
        "1_000",
        "0x10",
        "0o17",
        "2024-01-01",
        "nan",
        "inf",
        "Infinity",
        "e5",
        ".",
        "-",
        "+",
        "1e",
        "1.2.3",
        "1,5",
        "1e-3s",
        "01.5",
        "--1",
        "=",
    ],
)
def test_everything_else_is_a_text(text):
    assert resolve(text) == text


def test_inf_and_nan_are_floats_for_the_models_to_refuse():
    assert resolve(".inf") == math.inf
    assert resolve("-.inf") == -math.inf
    assert math.isnan(resolve(".nan"))
    assert resolve("1e309") == math.inf


def test_a_huge_integer_is_refused_and_the_largest_float_is_not():
    assert resolve("9" * 308) == int("9" * 308)
    with pytest.raises(ValueError, match="5000 digits"):
        resolve("1" * 5000)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_float_survives_its_repr(value):
    found = resolve(repr(value))
    assert isinstance(found, float)
    assert (found, math.copysign(1, found)) == (value, math.copysign(1, value))
