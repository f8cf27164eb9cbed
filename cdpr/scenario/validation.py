"""What the models of sections say of a document, each problem at its place."""

from __future__ import annotations

import json
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from cdpr.problems import Path
from cdpr.scenario.document import Document
from cdpr.scenario.messages import explain
from cdpr.scenario.problems import Problems

M = TypeVar("M", bound=BaseModel)


def validate(model: type[M], data: dict[str, Any], document: Document, problems: Problems) -> M | None:
    """Check `data`; as JSON, since strict models then take lists for tuples but convert nothing else."""
    try:
        return model.model_validate_json(json.dumps(data), context={"folder": document.folder})
    except ValidationError as error:
        for message in explain(error, model, data):
            mark = document.key_mark(message.path) if message.at_key else document.mark(message.path)
            problems.add(mark, message.path, message.text)
        return None


def report_nulls(node: Any, path: Path, document: Document, problems: Problems) -> None:
    """Refuse keys without a value also where the model could do without one."""
    if node is None and not problems.has(path):
        problems.add(document.mark(path), path, "no value is given; give one or remove the key")
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        report_nulls(item, (*path, key), document, problems)
