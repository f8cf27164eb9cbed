"""Sections with the numbers that the parts of cables declare."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import Field, create_model

from cdpr.base.fields import Section, unit
from cdpr.cables import MODELS, NUMBERS, TABLES, WINCH_TYPES


def _section_of(owner: str, *, shared: bool) -> type[Section]:
    """Return a section with the numbers that cable models use from "cable" or "winch".

    Numbers that are `shared` may be omitted from both sections; so may numbers that not all kinds of winch need.
    Missing required numbers are reported later.
    """
    kinds = [{number.name for number in chain.winch.accepted} for chain in MODELS.values() if chain.winch.numbers]
    others = [{number.name for number in part.required} for pair in WINCH_TYPES.values() for part in pair]
    fields: dict[str, Any] = {}
    for number in NUMBERS.values():
        if number.owner != owner:
            continue
        if number.table:
            table = TABLES[number.table]
            fields[table.key] = (table.kind | None, Field(None, description=table.text))
            continue
        needed = all(number.name in names for names in (*kinds, *others))
        usual = any(number.name in names for names in kinds)
        optional = shared or not usual or (number.default is None and not needed)
        default = None if optional else ... if number.default is None else number.default
        kind = number.kind | None if optional else number.kind
        extra = unit(number.unit) if number.unit else None
        fields[number.key] = (kind, Field(default, description=number.text, json_schema_extra=extra))
    return create_model(f"{owner}_numbers", __base__=Section, **fields)


# Base classes, so that these keys come between others: pydantic orders fields by base class, the last one first.
if TYPE_CHECKING:

    class CableNumbers(Section):
        """Numbers of a cable."""

    class WinchNumbers(Section):
        """Numbers of a winch."""
else:
    CableNumbers, WinchNumbers = _section_of("cable", shared=True), _section_of("winch", shared=False)
