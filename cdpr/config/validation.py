"""Validation of a document by the sections' models, with the position of each problem."""

from __future__ import annotations

import json
from contextlib import suppress
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError, create_model

from cdpr.base.problems import Path
from cdpr.config.describe import below
from cdpr.config.document import Document, same
from cdpr.config.messages import Search, explain
from cdpr.config.problems import Problems

M = TypeVar("M", bound=BaseModel)


def validate(
    model: type[M],
    data: dict[str, Any],
    document: Document,
    problems: Problems,
    before: tuple[M, dict[str, Any]] | None = None,
    search: Search | None = None,
) -> M | None:
    """Return the validated model, or None after reporting problems.

    Data are validated as JSON, in which strict models accept lists for tuples but convert nothing else.

    Args:
        model: model without checks across sections.
        data: data to validate.
        document: source of positions.
        problems: receives the problems.
        before: valid model, and its data, from which equal values are reused.
        search: other places of an unknown key; by default, all sections of `model`.
    """
    if before is not None:
        with suppress(ValidationError, KeyError):  # reported below for the whole model
            return _changed(*before, data, document.folder)
    try:
        return model.model_validate_json(json.dumps(data), context={"folder": document.folder})
    except ValidationError as error:
        for message in explain(error, model, data, search=search or (lambda key: below(model, (), data, key))):
            mark = document.key_mark(message.path) if message.at_key else document.mark(message.path)
            problems.add(mark, message.path, message.text)
        return None


def _changed(before: M, old: dict[str, Any], data: dict[str, Any], folder: str) -> M:
    """Return a model with the changes from its `old` data; KeyError if a key was removed or has an alias."""
    values: dict[str, Any] = {}
    for key in data.keys() | old.keys():
        value, field = data[key], type(before).model_fields[key]
        known: Any = old.get(key)
        if key in old and same(value, known):
            continue
        part, plain = getattr(before, key), not field.metadata and isinstance(value, dict) and isinstance(known, dict)
        if plain and isinstance(part, BaseModel) and field.annotation is type(part) and _independent(type(part)):
            values[key] = _changed(part, known, value, folder)
        else:
            text = json.dumps({key: value})
            checked = _part(type(before), key).model_validate_json(text, context={"folder": folder})
            values[key] = getattr(checked, key)
    return before.model_copy(update=values)


@lru_cache(maxsize=64)
def _independent(model: type[BaseModel]) -> bool:
    """Return True if no check or default of a model's key depends on other keys."""
    checks = model.__pydantic_decorators__
    return not (checks.model_validators or checks.field_validators) and not any(
        field.default_factory for field in model.model_fields.values()
    )


@lru_cache(maxsize=256)
def _part(model: type[BaseModel], name: str) -> type[BaseModel]:
    """Return a model with one of the keys."""
    fields: dict[str, Any] = {name: (model.model_fields[name].annotation, model.model_fields[name])}
    return create_model("Part", __config__=model.model_config, **fields)


def report_nulls(node: Any, path: Path, document: Document, problems: Problems, before: Any = None) -> None:
    """Report keys without a value, even if the model accepts null; what is shared with `before` has none."""
    if node is None and not problems.has(path):
        problems.add(document.mark(path), path, "no value is given; give one or remove the key")
    if node is not before:
        known = _items(before)
        for key, item in _items(node).items():
            report_nulls(item, (*path, key), document, problems, known.get(key))


def _items(node: Any) -> dict[Any, Any]:
    return node if isinstance(node, dict) else dict(enumerate(node)) if isinstance(node, list) else {}
