"""The options of plugins: checked by the model that the plugin declares, wherever they stand in a scenario."""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel, ValidationError

from cdpr.errors import PluginError
from cdpr.plugins.registry import Registry, Role, describe
from cdpr.scenario.document import Document
from cdpr.scenario.messages import explain
from cdpr.scenario.problems import Path, Problems


def read_options(
    role: Role,
    name: str,
    data: dict[str, Any],
    path: Path,
    core_keys: tuple[str, ...],
    document: Document,
    problems: Problems,
    plugins: Registry,
) -> BaseModel | None:
    """Return the options of a known plugin, None if they are wrong."""
    entry = plugins.get(role, name)
    model = entry.info.options
    try:
        return model.model_validate_json(json.dumps(data))
    except ValidationError as error:
        for message in explain(error, model, data, core_keys):
            place = (*path, *message.path)
            mark = document.key_mark(place) if message.at_key else document.mark(place)
            problems.add(mark, place, message.text)
        return None
    except Exception as error:  # the model is foreign code
        raise PluginError(
            f"{role} '{name}' of {entry.distribution} {entry.version}: its options cannot be checked: {describe(error)}"
        ) from error
