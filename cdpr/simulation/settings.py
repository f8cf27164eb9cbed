"""Options of controller and solver that change during a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from cdpr.base.errors import CdprError
from cdpr.plugins import Controller, TensionSolver
from cdpr.plugins.registry import Role
from cdpr.scenario.changes import Options


class Settings:
    """Changes of plugin options; `options` are those at the start."""

    def __init__(self, options: Options, plugins: Mapping[Role, Controller | TensionSolver]) -> None:
        self._options, self._plugins = options, plugins
        self._first = dict(options.values)
        self._changes: dict[str, Any] = {}

    def set(self, key: str, value: Any) -> None:
        """Change an option, named as in `controller.kp`.

        Raises:
            CdprError: if the plugin rejects it; nothing has changed.
        """
        values = self._options.values
        role = self._options.owner(key)
        before = values[role]
        self._options.change(key, value)
        try:
            self._plugins[role].change(values[role])
        except CdprError as error:
            values[role] = before
            raise type(error)(f"{key}: {error}") from error
        self._changes[key] = value

    def snapshot(self) -> Mapping[str, Any]:
        """Return the options that have changed since the start."""
        return dict(self._changes)

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore the options of a snapshot, also of another loop; all others are those at the start."""
        if snapshot == self._changes:
            return
        values = self._options.values
        roles = {self._options.owner(key) for key in {*snapshot, *self._changes}}
        values.update({role: self._first[role] for role in roles})
        for key, value in snapshot.items():
            self._options.change(key, value)
        for role in roles:
            self._plugins[role].change(values[role])
        self._changes = dict(snapshot)

    def reset(self) -> None:
        """Restore the options at the start."""
        self.restore({})

    def renew(self, options: Mapping[Role, BaseModel]) -> None:
        """Begin with other options in place of those at the start.

        Raises:
            CdprError: if a plugin rejects its options; others may have changed.
        """
        self.reset()
        for role, values in options.items():
            if values is not self._first[role]:
                self._plugins[role].change(values)
        self._options.values.update(options)
        self._first = dict(options)
