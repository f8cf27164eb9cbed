"""Finds the installed plugins, keeps a readable problem for each broken one, and makes the chosen one."""

from __future__ import annotations

import difflib
import importlib.metadata
import importlib.util
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from typing import Any, Literal

import pluggy
from pydantic import ValidationError

from cdpr.errors import CdprError, PluginError
from cdpr.plugins.info import INTERFACE_VERSION, Hooks, PluginInfo, PluginOptions

Role = Literal["backend", "controller", "solver"]
ROLES: tuple[Role, ...] = ("backend", "controller", "solver")

GROUP = "cdpr"
OWN_DISTRIBUTION = "cdpr"
DISABLE = "CDPR_DISABLE_PLUGINS"


@dataclass(frozen=True)
class Registered:
    """A plugin and the distribution that brought it."""

    role: Role
    info: PluginInfo
    distribution: str
    version: str

    @property
    def missing(self) -> list[str]:
        """Required modules that are not installed."""
        return [name for name in self.info.requires if not _found(name)]

    @property
    def remedy(self) -> str:
        """What to type so that this plugin can be used."""
        return f"pip install '{self.info.extra}'" if self.info.extra else "pip install " + " ".join(self.info.requires)

    def properties(self, options: PluginOptions) -> dict[str, object]:
        """Return what the plugin declares of itself with these options."""
        return {**self.info.properties, **options.declares()}

    def load(self) -> Any:
        """Import and return the factory; PluginError if a requirement is missing or the import fails."""
        title = f"{self.role} '{self.info.name}'"
        if missing := self.missing:
            raise PluginError(f"{title} needs {', '.join(missing)}, which is not installed: {self.remedy}")
        module, _, attribute = self.info.factory.partition(":")
        try:
            return getattr(import_module(module), attribute)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise PluginError(
                f"{title} of {self.distribution} {self.version} is installed but cannot be loaded from "
                f"{self.info.factory}: {describe(error)}"
            ) from error

    def make(self, *arguments: object) -> Any:
        """Load the factory and call it; PluginError, or the CdprError that it raises, if it cannot be made."""
        factory = self.load()
        try:
            return factory(*arguments)
        except CdprError:
            raise
        except Exception as error:
            raise PluginError(f"{self.role} '{self.info.name}' cannot be made: {describe(error)}") from error

    def read_options(self, values: Mapping[str, object]) -> PluginOptions:
        """Return options given as plain values, checked; PluginError if they are wrong."""
        try:
            return self.info.options.model_validate(dict(values))
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(map(str, first["loc"]))
            known = ", ".join(self.info.options.model_fields) or "none"
            raise PluginError(
                f"{self.role} '{self.info.name}', option {where}: {first['msg']}; its options are {known}"
            ) from error


@dataclass
class Registry:
    """All plugins found, by role and name, and what went wrong while looking."""

    plugins: dict[Role, dict[str, Registered]] = field(default_factory=lambda: {role: {} for role in ROLES})
    problems: list[str] = field(default_factory=list)

    def names(self, role: Role) -> list[str]:
        """Names that a scenario may use for `role`, sorted."""
        return sorted(self.plugins[role])

    def get(self, role: Role, name: str) -> Registered:
        """Return the plugin of this name, or else alias; PluginError with the nearest name and all if there is none."""
        found = self.plugins[role].get(name) or self._by_alias(role, name)
        if found is None:
            raise PluginError(unknown(role, name, self.names(role)))
        return found

    def _by_alias(self, role: Role, name: str) -> Registered | None:
        """Return the first plugin, by name, that is also known as `name`."""
        entries = (self.plugins[role][each] for each in self.names(role))
        return next((entry for entry in entries if name in entry.info.aliases), None)

    def add(self, role: Role, info: PluginInfo, distribution: str, version: str) -> None:
        """Register one row. Of two with one name the built-in wins; a stranger's is `distribution:name`."""
        entry = Registered(role, info, distribution, version)
        names = self.plugins[role]
        other = names.get(info.name)
        if other is None:
            names[info.name] = entry
            return
        if other.distribution == distribution:
            self.problems.append(f"{distribution}: two {role}s are named '{info.name}'; the first is used")
            return
        if other.distribution != OWN_DISTRIBUTION:
            del names[info.name]
            names[f"{other.distribution}:{info.name}"] = other
        names[f"{distribution}:{info.name}"] = entry
        self.problems.append(
            f"{distribution}: {role} '{info.name}' exists in {other.distribution} too; "
            f"write '{distribution}:{info.name}' to use this one"
        )


def _found(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):  # of a package that is missing itself
        return False


def unknown(role: Role, name: str, names: list[str]) -> str:
    """Error text for a name that no plugin has."""
    near = difflib.get_close_matches(name, names, n=1)
    hint = f"did you mean '{near[0]}'? " if near else ""
    return f"no {role} is named '{name}': {hint}installed are {', '.join(names)} (see 'cdpr plugins')"


def describe(error: BaseException) -> str:
    """One line for an exception raised by foreign code."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


@lru_cache(maxsize=1)
def registry() -> Registry:
    """Return the plugins of the installed distributions; looked for once per process."""
    entry_points = importlib.metadata.entry_points(group=GROUP)
    return collect(entry_points, disabled=bool(os.environ.get(DISABLE)))


def collect(entry_points: Iterable[importlib.metadata.EntryPoint], *, disabled: bool = False) -> Registry:
    """Build a registry. A failing plugin is left out and described; it never stops the others.

    Built-ins come first and the rest in the order of distribution and name, so that the outcome does not depend on
    the order of the path. With `disabled`, third parties are not even imported.
    """
    result = Registry()

    def key(point: importlib.metadata.EntryPoint) -> tuple[bool, str, str]:
        name = point.dist.name if point.dist else ""
        return (name != OWN_DISTRIBUTION, name, point.name)

    for point in sorted(entry_points, key=key):
        distribution = point.dist.name if point.dist else "unknown"
        version = point.dist.version if point.dist else "?"
        if disabled and distribution != OWN_DISTRIBUTION:
            continue
        try:
            rows = _rows(point)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            result.problems.append(f"{distribution} {version}, entry point '{point.name}': {describe(error)}")
            continue
        for role, info in rows:
            result.add(role, info, distribution, version)
    return result


def _rows(point: importlib.metadata.EntryPoint) -> list[tuple[Role, PluginInfo]]:
    """Load one entry point and ask all its hooks."""
    manager = pluggy.PluginManager("cdpr")
    manager.add_hookspecs(Hooks)
    plugin = point.load()
    manager.register(plugin)
    manager.check_pending()  # a misspelt hook is a problem, not silence
    rows: list[tuple[Role, PluginInfo]] = []
    for role in ROLES:
        for answer in getattr(manager.hook, f"cdpr_{role}s")():
            for info in answer:
                if not isinstance(info, PluginInfo):
                    raise PluginError(f"cdpr_{role}s() returned {type(info).__name__}, not PluginInfo")
                if info.interface != INTERFACE_VERSION:
                    raise PluginError(
                        f"{role} '{info.name}' was written for interface {info.interface}; this cdpr has "
                        f"{INTERFACE_VERSION}: install versions that match"
                    )
                rows.append((role, info))
    if not rows:
        raise PluginError("it implements no hook: cdpr_backends, cdpr_controllers or cdpr_solvers (marked @hookimpl)")
    return rows
