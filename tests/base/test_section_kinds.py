"""Sections of several kinds, imported when they are first used."""

from __future__ import annotations

import json
from typing import Annotated

import pytest
from pydantic import Field, TypeAdapter, ValidationError

from cdpr.base.fields import Section
from cdpr.base.kinds import Kinds
from cdpr.cables import EXITS, AnyExit, Exit
from cdpr.cables.point import Point
from cdpr.cables.pulley import Pulley
from cdpr.scenario.events import EVENTS
from cdpr.scenario.motions import MOTIONS

DATA = {"type": "pulley", "radius": 0.1, "axis": [0.0, 0.0, 1.0]}


class Holder(Section):
    """Section with a part of several kinds."""

    part: AnyExit | None = Field(None, description="part")


@pytest.mark.parametrize("kinds", [EVENTS, MOTIONS, EXITS])
def test_each_name_is_the_type_of_its_section(kinds):
    assert {name: section.kind() for name, section in kinds.items()} == {name: name for name in kinds}


def test_data_become_the_section_of_their_type():
    part = EXITS.read(DATA)
    assert part == Pulley(type="pulley", radius=0.1, axis=(0.0, 0.0, 1.0))
    assert Holder(part=part).part == part
    assert Holder.model_validate({"part": {**DATA, "axis": (0.0, 0.0, 1.0)}}).part == part
    assert Holder(part=part).model_dump(mode="json", exclude_none=True) == {"part": DATA}


def test_errors_have_the_places_of_a_union():
    union = TypeAdapter(Annotated[Point | Pulley, Field(discriminator="type")])
    for data in ({}, 3, {"type": "pully"}, {"type": ["pulley"]}, {**DATA, "radius": "1"}, {**DATA, "axes": 1}):
        with pytest.raises(ValidationError) as found:
            EXITS.read(data)
        with pytest.raises(ValidationError) as expected:
            union.validate_json(json.dumps(data))
        assert found.value.errors() == expected.value.errors()


def test_the_schema_is_that_of_a_union():
    union: TypeAdapter[Exit] = TypeAdapter(Annotated[Point | Pulley, Field(discriminator="type")])
    assert TypeAdapter(Annotated[object, EXITS]).json_schema() == union.json_schema()


def test_a_table_is_a_mapping():
    kinds: Kinds[Exit] = Kinds({"pulley": "cdpr.cables.pulley:Pulley"})
    assert dict(kinds) == {"pulley": Pulley}
    assert len(kinds) == 1
    assert "point" not in kinds
    assert ["pulley"] not in kinds
    with pytest.raises(KeyError):
        kinds["point"]
