"""The options of controller and solver that are in force, and what may change of them while they run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from cdpr.errors import CdprError, PluginError, one_line
from cdpr.nearest import did_you_mean
from cdpr.plugins.registry import Registered, Role
from cdpr.problems import Path, dotted
from cdpr.scenario.messages import explain


class RefusedError(CdprError):
    """An option that cannot be changed so: `faults` are (path, text), below `key` or `value` of what asked for it."""

    def __init__(self, key: str, faults: list[tuple[Path, str]]) -> None:
        told = [text if path == ("key",) else f"{key}{dotted(path[1:])}: {text}" for path, text in faults]
        super().__init__("; ".join(told))
        self.faults = faults


class Options:
    """Options in force, by role.

    Attributes:
        values: an instance of the plugin's model each.
    """

    def __init__(self, plugins: Mapping[Role, Registered], values: Mapping[Role, BaseModel], folder: str) -> None:
        self._plugins, self._folder = plugins, folder
        self.values = dict(values)

    def changeable(self) -> list[str]:
        """Return the keys that may change."""
        return [f"{role}.{name}" for role, entry in self._plugins.items() for name in entry.info.changeable]

    def numbers(self) -> dict[str, float]:
        """Return those that may change and are one number, with their values."""
        found = {key: getattr(self.values[self.owner(key)], key.partition(".")[2], None) for key in self.changeable()}
        numbers = {key: value for key, value in found.items() if isinstance(value, int | float)}
        return {key: float(value) for key, value in numbers.items() if not isinstance(value, bool)}

    def owner(self, key: str) -> Role:
        """Return whose option `key` is; RefusedError where it may not change."""
        for role, entry in self._plugins.items():
            if key in (f"{role}.{name}" for name in entry.info.changeable):
                return role
        keys = self.changeable()
        may = f"what may: {', '.join(keys)}" if keys else "nothing of this controller and this solver may"
        raise RefusedError(key, [(("key",), f"'{key}' cannot change during a run: {did_you_mean(key, keys)}{may}")])

    def change(self, key: str, value: Any) -> None:
        """Give an option, named as in `controller.kp`, another value.

        Raises RefusedError where it may not change, or where its plugin does not take the value.
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
        except Exception as error:  # the model is foreign code
            title = f"the options of {role} '{entry.info.name}'"
            raise PluginError(f"{title} cannot be checked: {one_line(error)}") from error
