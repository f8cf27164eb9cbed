"""Declarations of cable parts."""

from __future__ import annotations

import re
from dataclasses import fields

import pytest

from cdpr.base.errors import CdprError
from cdpr.base.fields import Positive
from cdpr.cables import NUMBERS, chain
from cdpr.cables.chain import Number, Span
from cdpr.model import Cable, Winch
from cdpr.scenario.robot_schema import CableSection, CablesSection, WinchSection

SAID = {"cable": (Cable, CableSection, CablesSection), "winch": (Winch, WinchSection)}  # where a key would clash


@pytest.mark.parametrize("owner", SAID)
def test_a_number_takes_no_name_that_means_something_else(owner):
    """Such as a cable's `name` or `winch`: robot files would have lost that key, without a word."""
    model, *sections = SAID[owner]
    names = {field.name for field in fields(model)}.union(*(dir(one) for one in sections))
    names = names.union(*(one.model_fields for one in sections))
    names -= {number.key for number in NUMBERS.values() if number.owner == owner}
    for name in sorted(name for name in names if name[0] != "_"):
        number = Number(f"{owner}.{name}", Positive, "m", "something else")
        for part in (Span, chain.Winch):
            with pytest.raises(CdprError, match=f"^mine.hpp: its number {owner}.{name} has a reserved name") as told:
                part(header="mine.hpp", numbers=(number,))
            assert re.search(rf"\b{name}\b", str(told.value).partition("reserved names")[2])
            assert "\n" not in str(told.value)
    with pytest.raises(CdprError, match=r"expected a name such as cable\.KEY or winch\.KEY"):
        Number(f"{owner}._hidden", Positive, "m", "something else")
    assert Span(header="mine.hpp", numbers=(Number(f"{owner}.lay", Positive, "m", "lay length"),)).numbers
