"""Construction of sections from keyword arguments in Python, such as Quintic(duration=2.0, ...)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from cdpr.base.errors import CdprError
from cdpr.base.problems import Path, dotted, first_ones
from cdpr.config.messages import explain
from cdpr.config.overrides import NotPlainError, plain_value

M = TypeVar("M", bound=BaseModel)


def from_arguments(model: type[M], values: Mapping[str, Any]) -> M:
    """Return a section of arguments by field name: arrays, dicts and other sections count as lists and mappings.

    Raises:
        CdprError: with all problems, each with the name of its argument.
    """
    name = model.__name__
    aliases = {key: field.alias or key for key, field in model.model_fields.items()}
    try:
        data = {aliases.get(key, key): plain_value(value, (key,)) for key, value in values.items()}
    except NotPlainError as error:
        raise CdprError(f"{argument(name, error.path)}: {error}") from None
    try:
        return model.model_validate_json(json.dumps(data))
    except ValidationError as error:
        keys = {alias: key for key, alias in aliases.items()}
        lines = []
        for each in explain(error, model, data):
            path = (keys.get(str(each.path[0]), each.path[0]), *each.path[1:]) if each.path else ()
            lines.append(f"{argument(name, path)}: {each.text}")
        raise CdprError("\n".join(first_ones(lines))) from None


def argument(name: str, path: Path) -> str:
    """Return the name of an argument of a function or class, or of a value in it: Quintic(to=).position[0]."""
    if not path:
        return name
    rest = dotted(path[1:])
    return f"{name}({path[0]}=){'' if not rest or rest.startswith('[') else '.'}{rest}"
