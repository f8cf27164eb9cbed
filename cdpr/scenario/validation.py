"""What the models of sections say of a document, each problem at its place."""

from __future__ import annotations

import json
from collections.abc import Set
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError, create_model

from cdpr.problems import Path
from cdpr.scenario.document import Document
from cdpr.scenario.messages import explain
from cdpr.scenario.problems import Problems

M = TypeVar("M", bound=BaseModel)


def validate(
    model: type[M],
    data: dict[str, Any],
    document: Document,
    problems: Problems,
    before: M | None = None,
    unchanged: Set[str] = frozenset(),
) -> M | None:
    """Check `data`; as JSON, since strict models then take lists for tuples but convert nothing else.

    Sections `unchanged` are those of what was found `before` in other data; the model has no check across sections.
    """
    if before is not None:
        changed = frozenset(data.keys() | before.model_fields_set) - unchanged
        try:
            if changed <= data.keys() & type(before).model_fields.keys():
                text = json.dumps({key: data[key] for key in changed})
                part = _part(model, changed).model_validate_json(text, context={"folder": document.folder})
                return before.model_copy(update={key: getattr(part, key) for key in changed})
        except ValidationError:
            pass  # told below, as of the whole
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
    """Refuse keys without a value also where the model could do without one."""
    if node is None and not problems.has(path):
        problems.add(document.mark(path), path, "no value is given; give one or remove the key")
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        report_nulls(item, (*path, key), document, problems)
