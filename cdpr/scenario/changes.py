"""Current options of controller and solver, and changes during a run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from cdpr.base.errors import CdprError, PluginError, one_line
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Path, dotted, first_ones
from cdpr.config.messages import explain
from cdpr.plugins.registry import Registered, Role


class RefusedError(CdprError):
    """Rejected change of an option; `faults` are (path, text), relative to `key` or `value` of the request."""

    def __init__(self, key: str, faults: list[tuple[Path, str]]) -> None:
        texts = [text if path == ("key",) else f"{key}{dotted(path[1:])}: {text}" for path, text in faults]
        super().__init__("; ".join(first_ones(texts)))
        self.faults = faults


class Options:
    """Current options by role.

    Attributes:
        values: instance of each plugin's options model.
    """

    def __init__(self, plugins: Mapping[Role, Registered], values: Mapping[Role, BaseModel], folder: str) -> None:
        self._plugins, self._folder = plugins, folder
        self.values = dict(values)

    def changeable(self) -> list[str]:
        """Return the keys that may change."""
        return [f"{role}.{name}" for role, entry in self._plugins.items() for name in entry.info.changeable]

    def numbers(self) -> dict[str, float]:
        """Return the changeable options that are single numbers, with their values."""
        found = {key: getattr(self.values[self.owner(key)], key.partition(".")[2], None) for key in self.changeable()}
        numbers = {key: value for key, value in found.items() if isinstance(value, int | float)}
        return {key: float(value) for key, value in numbers.items() if not isinstance(value, bool)}

    def owner(self, key: str) -> Role:
        """Return the role of the option `key`; raise RefusedError if it may not change."""
        for role, entry in self._plugins.items():
            if key in (f"{role}.{name}" for name in entry.info.changeable):
                return role
        keys = self.changeable()
        may = f"allowed: {', '.join(keys)}" if keys else "this controller and this solver have no changeable options"
        raise RefusedError(key, [(("key",), f"'{key}' cannot change during a run: {did_you_mean(key, keys)}{may}")])

    def change(self, key: str, value: Any) -> None:
        """Set an option, named as in `controller.kp`.

        Raises:
            RefusedError: if it may not change, or the plugin rejects the value.
            PluginError: if the plugin's model raises another exception.
        """
        role, name = self.owner(key), key.partition(".")[2]
        entry = self._plugins[role]
        present, model = self.values[role], entry.info.options
        try:
            try:
                data = {**present.model_dump(mode="json", by_alias=True), name: value}
                context = {"folder": self._folder}
                self.values[role] = model.model_validate_json(json.dumps(data), strict=True, context=context)
            except ValidationError as error:
                faults = [(("value", *one.path[1:]), one.text) for one in explain(error, model, data)]
                raise RefusedError(key, faults) from None
        except CdprError:
            raise
        except Exception as error:  # the model is third-party code
            title = f"the options of {role} '{entry.info.name}'"
            raise PluginError(f"{title} cannot be checked: {one_line(error)}") from error
