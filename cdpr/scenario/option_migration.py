"""Handling of options when another controller or solver plugin is selected."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import FrameType
from typing import Any

from pydantic_core import PydanticUndefined

from cdpr.base.errors import OptionsLeftOut, PluginError
from cdpr.base.problems import Mark, dotted, shown
from cdpr.config.document import Document
from cdpr.plugins.info import PluginOptions
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.choices import CORE_KEYS, DEFAULT_TYPE


@dataclass(frozen=True)
class _Before:
    """Section as in the file: plugin, and position of each option."""

    role: Role
    type: Any
    marks: dict[str, Mark | None]


class Replacement:
    """Adjustment of controller and solver options after all changes.

    Options belong to their plugin: the gain of one controller may have another meaning or unit in another. If another
    plugin is selected, the file's options are dropped, and options given with the change are kept. `Document.notes`
    reports both, and the defaults that apply.
    """

    def __init__(self, document: Document, plugins: Registry) -> None:
        self._document = document
        self._plugins = plugins
        roles: tuple[Role, ...] = ("controller", "solver", "estimator")
        self._before = [self._given_options(role) for role in roles]

    def _given_options(self, role: Role) -> _Before:
        given = self._document.data.get(role)
        options = [key for key in given if key not in CORE_KEYS[role]] if isinstance(given, dict) else []
        return _Before(role, self._type(role), {key: self._document.key_mark((role, key)) for key in options})

    def _type(self, role: Role) -> Any:
        name = self._document.get((role, "type"))
        return DEFAULT_TYPE[role] if name is None else name

    def settle(self) -> None:
        """Drop the options of replaced plugins."""
        for before in self._before:
            name = self._type(before.role)
            given = self._document.data.get(before.role)
            if name == before.type or not isinstance(name, str) or not isinstance(given, dict):
                continue
            try:
                model = self._plugins.get(before.role, name).info.options
            except PluginError:
                continue  # reported later
            self._settle(before, name, given, model)

    def _settle(self, before: _Before, name: str, given: dict[str, Any], model: type[PluginOptions]) -> None:
        document, role = self._document, before.role
        old = [key for key, mark in before.marks.items() if key in given and document.key_mark((role, key)) is mark]
        for key in old:
            document.drop((role, key))
            document.dropped.append(dotted((role, key)))
        left = {key: value for key, value in given.items() if key not in old}
        if note := replacement_note(role, shown(before.type).strip(chr(39)), name, old, left, model):
            document.notes.append(note)
            if old:
                warnings.warn(note, OptionsLeftOut, stacklevel=outside())


def replacement_note(
    role: Role, before: str, name: str, left_out: Sequence[str], given: Mapping[str, Any], model: type[PluginOptions]
) -> str:
    """Return a note on the options after a change of plugin; "" if neither plugin has any.

    Args:
        role: role of both plugins.
        before: name of the old plugin.
        name: name of the new plugin.
        left_out: dropped options of the old plugin.
        given: current section.
        model: options of the new plugin.
    """
    fields = {field.alias or key: field for key, field in model.model_fields.items()}
    defaults = {key: field.get_default() for key, field in fields.items() if key not in given}
    old_default = (None, PydanticUndefined)
    default = [f"{key} = {shown(value)}" for key, value in defaults.items() if value not in old_default]
    kept = [key for key in given if key in CORE_KEYS[role] and key != "type"]
    parts = [
        *([f"left out {', '.join(left_out)}"] if left_out else []),
        *([f"kept {', '.join(kept)}"] if kept and left_out else []),
        *([f"by default {', '.join(default)}"] if default else []),
    ]
    return f"{role} {name} in place of {before}: {'; '.join(parts)}" if parts else ""


def outside() -> int:
    """Return the `stacklevel` of the first caller outside this package, for a warning."""
    package, level = os.path.dirname(os.path.dirname(__file__)) + os.sep, 1
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith(package):
        frame, level = frame.f_back, level + 1
    return level
