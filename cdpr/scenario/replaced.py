"""What becomes of a plugin's options where another one is chosen from outside."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError
from pydantic_core import PydanticUndefined

from cdpr.errors import PluginError
from cdpr.plugins.info import PluginOptions
from cdpr.plugins.registry import Registry, Role
from cdpr.problems import Mark, dotted, shown
from cdpr.scenario.document import Document
from cdpr.scenario.overrides import CORE_KEYS, DEFAULT_TYPE


@dataclass(frozen=True)
class _Before:
    """A section as the file has it: the plugin, and where each of its options stands."""

    role: Role
    type: Any
    marks: dict[str, Mark | None]


class Replacement:
    """Settles the options of controller and solver after all changes: what was given with the change always stays.

    Of the file's options those stay that the new plugin takes, too; the others are left out. Both, and what the new
    plugin has besides, are told in `Document.notes`.
    """

    def __init__(self, document: Document, plugins: Registry) -> None:
        self._document = document
        self._plugins = plugins
        roles: tuple[Role, ...] = ("controller", "solver")
        self._before = [self._look(role) for role in roles]

    def _look(self, role: Role) -> _Before:
        given = self._document.data.get(role)
        options = [key for key in given if key not in CORE_KEYS[role]] if isinstance(given, dict) else []
        return _Before(role, self._type(role), {key: self._document.keys.get((role, key)) for key in options})

    def _type(self, role: Role) -> Any:
        name = self._document.get((role, "type"))
        return DEFAULT_TYPE[role] if name is None else name

    def settle(self) -> None:
        """Leave out what the chosen plugins do not take of the options of those that they replace."""
        for before in self._before:
            name = self._type(before.role)
            given = self._document.data.get(before.role)
            if name == before.type or not isinstance(name, str) or not isinstance(given, dict):
                continue
            try:
                model = self._plugins.get(before.role, name).info.options
            except PluginError:
                continue  # will be told
            self._settle(before, name, given, model)

    def _settle(self, before: _Before, name: str, given: dict[str, Any], model: type[PluginOptions]) -> None:
        document, role = self._document, before.role
        old = [key for key, mark in before.marks.items() if key in given and document.keys.get((role, key)) is mark]
        fields = {field.alias or key: field for key, field in model.model_fields.items()}
        kept = [key for key in old if key in fields]
        kept = [key for key in kept if key not in refused(model, {key: given[key] for key in kept}, document.folder)]
        for key in old:
            if key not in kept:
                document.drop((role, key))
                document.dropped.append(dotted((role, key)))
        defaults = {key: field.get_default() for key, field in fields.items() if key not in given}
        said = (None, PydanticUndefined)
        default = [f"{key} = {shown(value)}" for key, value in defaults.items() if value not in said]
        parts = [
            *([f"kept {', '.join(kept)} of the file"] if kept else []),
            *([f"left out {', '.join(key for key in old if key not in kept)}"] if len(kept) < len(old) else []),
            *([f"by default {', '.join(default)}"] if default else []),
        ]
        if parts:
            document.notes.append(f"{role} {name} in place of {shown(before.type).strip(chr(39))}: {'; '.join(parts)}")


def refused(model: type[PluginOptions], values: dict[str, Any], folder: str) -> set[str]:
    """Return the keys whose values the model does not take."""
    try:
        model.model_validate_json(json.dumps(values), strict=True, context={"folder": folder})
    except ValidationError as error:
        return {str(fault["loc"][0]) for fault in error.errors(include_url=False) if fault["loc"]}
    except Exception:
        return set()  # the model is foreign code: the check of the options will say what is the matter with it
    return set()
