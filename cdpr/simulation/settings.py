"""Options of controller and solver that change during a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from cdpr.errors import CdprError
from cdpr.plugins import Controller, TensionSolver
from cdpr.plugins.registry import Role
from cdpr.scenario.changes import Options


class Settings:
    """Hands plugins the options that change; `options` are those at the start."""

    def __init__(self, options: Options, plugins: Mapping[Role, Controller | TensionSolver]) -> None:
        self._options, self._plugins = options, plugins
        self._first = self.snapshot()

    def set(self, key: str, value: Any) -> None:
        """Change an option, named as in `controller.kp`. Raises CdprError, having changed nothing."""
        values = self._options.values
        role = self._options.owner(key)
        before = values[role]
        self._options.change(key, value)
        try:
            self._plugins[role].change(values[role])
        except CdprError as error:
            values[role] = before
            raise type(error)(f"{key}: {error}") from error

    def snapshot(self) -> Mapping[Role, BaseModel]:
        """Return the options in force."""
        return dict(self._options.values)

    def restore(self, snapshot: Mapping[Role, BaseModel]) -> None:
        """Go back to the options of a snapshot."""
        for role, options in snapshot.items():
            if options is not self._options.values[role]:
                self._plugins[role].change(options)
                self._options.values[role] = options

    def reset(self) -> None:
        """Go back to the options at the start."""
        self.restore(self._first)
