"""Declarations of cable parts."""

from __future__ import annotations

import re
from dataclasses import fields, replace

import numpy as np
import pytest
from conftest import ROOT, crossed_box, make_robot

from cdpr.base.errors import CdprError
from cdpr.base.fields import Positive
from cdpr.cables import NUMBERS, chain
from cdpr.cables.chain import COORDINATE, MOST_STATES, Chain, Number, Span
from cdpr.cables.drum import DRUM
from cdpr.cables.elastic import ELASTIC
from cdpr.cables.inextensible import INEXTENSIBLE
from cdpr.cables.tables import places_of_states
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


def test_a_winch_declares_its_states():
    """Those of its coordinate are states only with a span that stretches; the others always are."""
    lagged = replace(DRUM, states=COORDINATE + 3)
    assert [Chain(winch, span).states for winch in (DRUM, lagged) for span in (ELASTIC, INEXTENSIBLE)] == [2, 0, 5, 3]
    for states in (-1, 1, MOST_STATES + 1, 2.5, None, "2"):
        with pytest.raises(CdprError, match=rf"drum\.hpp: states: expected 0, or 2 to 16, got {states!r}$"):
            replace(DRUM, states=states)
    with pytest.raises(CdprError, match="an immediate winch has no states"):
        replace(DRUM, immediate=True)
    with pytest.raises(CdprError, match=r"elastic\.hpp: a span that stretches needs a winch with the states"):
        Chain(replace(DRUM, states=0), ELASTIC)


def test_cables_of_one_robot_differ_in_states():
    robot = make_robot(crossed_box(np.random.default_rng(1), 4))
    models = ("elastic", "ideal", "rigid", "elastic")
    cables = (replace(cable, model=model) for cable, model in zip(robot.cables, models, strict=True))
    assert places_of_states(replace(robot, cables=tuple(cables))).tolist() == [0, 2, 2, 2, 4]


def test_kernels_know_the_same_sizes():
    sizes = {}
    for name in ("chain", "winch_tension"):
        text = (ROOT / "cdpr" / "cables" / f"{name}.hpp").read_text()
        sizes.update(re.findall(r"constexpr int (COORDINATE|MOST_STATES) = (\d+);", text))
    assert sizes == {"COORDINATE": str(COORDINATE), "MOST_STATES": str(MOST_STATES)}
