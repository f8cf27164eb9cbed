"""Validation of a document by the sections' models, with the position of each problem."""

from __future__ import annotations

import json
from collections.abc import Set
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError, create_model

from cdpr.base.problems import Path
from cdpr.config.document import Document
from cdpr.config.messages import explain
from cdpr.config.problems import Problems

M = TypeVar("M", bound=BaseModel)


def validate(
    model: type[M],
    data: dict[str, Any],
    document: Document,
    problems: Problems,
    before: M | None = None,
    unchanged: Set[str] = frozenset(),
) -> M | None:
    """Return the validated model, or None after reporting problems.

    Data are validated as JSON, in which strict models accept lists for tuples but convert nothing else.

    Args:
        model: model without checks across sections.
        data: data to validate.
        document: source of positions.
        problems: receives the problems.
        before: model of other data, from which `unchanged` sections are reused.
        unchanged: names of equal sections.
    """
    if before is not None:
        changed = frozenset(data.keys() | before.model_fields_set) - unchanged
        try:
            if changed <= data.keys() & type(before).model_fields.keys():
                text = json.dumps({key: data[key] for key in changed})
                part = _part(model, changed).model_validate_json(text, context={"folder": document.folder})
                return before.model_copy(update={key: getattr(part, key) for key in changed})
        except ValidationError:
            pass  # reported below for the whole model
    try:
        return model.model_validate_json(json.dumps(data), context={"folder": document.folder})
    except ValidationError as error:
        for message in explain(error, model, data):
            mark = document.key_mark(message.path) if message.at_key else document.mark(message.path)
            problems.add(mark, message.path, message.text)
        return None


@lru_cache(maxsize=16)
def _part(model: type[BaseModel], names: frozenset[str]) -> type[BaseModel]:
    """Return a model of some of the sections."""
    fields: dict[str, Any] = {name: (model.model_fields[name].annotation, model.model_fields[name]) for name in names}
    return create_model("Part", __config__=model.model_config, **fields)


def report_nulls(node: Any, path: Path, document: Document, problems: Problems) -> None:
    """Report keys without a value, even if the model accepts null."""
    if node is None and not problems.has(path):
        problems.add(document.mark(path), path, "no value is given; give one or remove the key")
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        report_nulls(item, (*path, key), document, problems)
