"""Tables of sections that have several kinds, distinguished by `type`.

A table maps the value of `type` to the "module:Class" of its section. The module is imported, and its validator built,
when a file first uses the type, since a file uses few of them. To add a kind, write its module and its table entry.

    MOTIONS: Kinds[Motion] = Kinds({"hold": "cdpr.scenario.motions.hold:Hold", ...})
    AnyMotion = Annotated[Motion, MOTIONS]  # type of a field
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cached_property, partial, reduce
from importlib import import_module
from operator import or_
from typing import Annotated, Any, Generic, TypeVar

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from cdpr.base.fields import Kind

K = TypeVar("K", bound=Kind)


class Kinds(Mapping[str, type[K]], Generic[K]):
    """Sections by the value of `type`; as metadata of an annotation, it validates a section of any of these kinds.

    Attributes:
        homes: "module:Class" of each section.

    Example:
        >>> from cdpr.cables import EXITS
        >>> list(EXITS)
        ['point', 'pulley']
        >>> EXITS["pulley"].__name__
        'Pulley'
    """

    def __init__(self, homes: Mapping[str, str]) -> None:
        self.homes = homes

    def __getitem__(self, name: str) -> type[K]:
        """Import and return a section."""
        module, _, attribute = self.homes[name].partition(":")
        section: type[K] = getattr(import_module(module), attribute)
        return section

    def __iter__(self) -> Iterator[str]:
        return iter(self.homes)

    def __len__(self) -> int:
        return len(self.homes)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self.homes

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return a union by `type` whose members are imported when they validate a value."""
        members: dict[Any, CoreSchema] = {
            name: core_schema.with_info_plain_validator_function(partial(self._read_as, name)) for name in self
        }
        return core_schema.tagged_union_schema(members, discriminator="type")

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON Schema of all kinds."""
        union: Any = Annotated[reduce(or_, self.values()), Field(discriminator="type")]
        return handler(TypeAdapter(union).core_schema)

    def read(self, data: Any) -> K:
        """Return the section with plain data of a file.

        Raises:
            pydantic.ValidationError: if they are invalid.
        """
        return self._adapter.validate_json(json.dumps(data))

    @cached_property
    def _adapter(self) -> TypeAdapter[K]:
        return TypeAdapter(Annotated[Any, self])

    def _read_as(self, name: str, value: Any, info: ValidationInfo) -> K:
        section = self[name]
        if info.mode == "json":  # as JSON, strict models accept lists for tuples
            return section.model_validate_json(json.dumps(value), context=info.context)
        return section.model_validate(value, context=info.context)
