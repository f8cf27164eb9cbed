"""Plugin options, validated by the plugins' models."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from cdpr.base.errors import PluginError, one_line
from cdpr.base.problems import Path
from cdpr.config.describe import below, describe
from cdpr.config.document import Document
from cdpr.config.messages import explain
from cdpr.config.problems import Problems
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.choices import CORE_KEYS, DEFAULT_TYPE
from cdpr.scenario.schema import ScenarioSection, Simulation


@dataclass(frozen=True)
class OptionsReader:
    """Reader of a document's options; on errors it adds to `problems` and returns None."""

    document: Document
    problems: Problems
    plugins: Registry

    def of_section(self, role: Role, options: dict[str, Any]) -> BaseModel | None:
        """Return the plugin options in the section `role`."""
        name = self.document.get((role, "type"))
        name = DEFAULT_TYPE[role] if name is None else name
        if not self._known(role, name, (role, "type")):
            return None
        return self._read(role, name, options, (role,), CORE_KEYS[role])

    def of_backends(self) -> dict[str, BaseModel]:
        """Return the options of all backends that are given, and of the selected one."""
        given = self.document.get(("backend_options",))
        given = dict(given) if isinstance(given, dict) else {}
        chosen = self.document.get(("simulation", "backend"))
        chosen = Simulation.model_fields["backend"].default if chosen is None else chosen
        if self._known("backend", chosen, ("simulation", "backend")):
            given.setdefault(chosen, {})
        result: dict[str, BaseModel] = {}
        for name, options in given.items():
            path = ("backend_options", name)
            if (name == chosen or self._known("backend", name, path)) and isinstance(options, dict):
                read = self._read("backend", name, options, path, ())
                if read is not None:
                    result[name] = read
        return result

    def places(self, key: str) -> list[Path]:
        """Return the places of this key in the scenario, with the options of the selected plugins."""
        found = below(ScenarioSection, (), self.document.data, key)
        return found + [path for path in self._option_paths() if path[-1] == key and path not in found]

    def _option_paths(self) -> list[Path]:
        """Return the paths of all options of the selected plugins."""
        backend = self.document.get(("simulation", "backend")) or Simulation.model_fields["backend"].default
        roles: tuple[Role, ...] = ("controller", "solver", "estimator")
        selected: list[tuple[Role, object, Path]] = [
            *((role, self.document.get((role, "type")) or DEFAULT_TYPE[role], (role,)) for role in roles),
            ("backend", backend, ("backend_options", str(backend))),
        ]
        paths: list[Path] = []
        for role, name, section in selected:
            with suppress(PluginError):  # reported where its options are read
                model = self.plugins.get(role, str(name)).info.options
                paths += [(*section, key) for key in describe(model, (), {}).keys]
        return paths

    def _known(self, role: Role, name: Any, path: Path) -> bool:
        if not isinstance(name, str):
            return False  # reported as a wrong type by cdpr's own models
        try:
            self.plugins.get(role, name)
        except PluginError as error:
            self.problems.add(self.document.key_mark(path), path, str(error), plugin=True)
            return False
        return True

    def _read(
        self, role: Role, name: str, data: dict[str, Any], path: Path, core_keys: tuple[str, ...]
    ) -> BaseModel | None:
        entry = self.plugins.get(role, name)
        model = entry.info.options
        try:
            try:
                # Always strict: no silent conversions, even if the plugin's model allows them.
                context = {"folder": self.document.folder}  # base of relative file names
                return model.model_validate_json(json.dumps(data), strict=True, context=context)
            except ValidationError as error:
                messages = explain(error, model, data, core_keys, self.places, path)
        except Exception as error:  # the model is third-party code
            text = f"the options of {role} '{name}' of {entry.distribution} {entry.version} cannot be checked"
            self.problems.add(self.document.mark(path), path, f"{text}: {one_line(error)}", plugin=True)
            return None
        for message in messages:
            place = (*path, *message.path)
            mark = self.document.key_mark(place) if message.at_key else self.document.mark(place)
            self.problems.add(mark, place, message.text)
        return None
