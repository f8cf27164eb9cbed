"""Registry of installed plugins with a readable problem for each broken one, and their construction."""

from __future__ import annotations

import contextlib
import importlib.metadata
import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib import import_module
from itertools import groupby
from operator import attrgetter
from typing import Any

import pluggy
from pydantic import ValidationError

from cdpr.base.column import Column
from cdpr.base.errors import CdprError, PluginError, one_line
from cdpr.base.nearest import did_you_mean
from cdpr.base.redirect_output import redirect_output
from cdpr.plugins.classes import PluginFile, classes_of, describe_class, innermost, read_file, role_of, source_version
from cdpr.plugins.info import INTERFACE_VERSION, Hooks, PluginInfo, PluginOptions
from cdpr.plugins.info import Role as Role  # modules that choose a plugin import it from here

ROLES: tuple[Role, ...] = ("backend", "controller", "solver", "estimator")

GROUP = "cdpr"
OWN_DISTRIBUTION = "cdpr"
DISABLE = "CDPR_DISABLE_PLUGINS"


# Methods of backends under their names in earlier checkouts, which the loop no longer calls.
RENAMED_METHODS = {"acts": "operations", "engine_acts": "engine_operations"}


@dataclass(frozen=True)
class Registered:
    """Plugin with the distribution, file or module that provides it; classes that are not installed are included."""

    role: Role
    info: PluginInfo
    distribution: str
    version: str
    factory: type | None = None

    @property
    def missing(self) -> list[str]:
        """Required modules that are not installed."""
        return [name for name in self.info.requires if not _found(name)]

    @property
    def remedy(self) -> str:
        """Command that makes this plugin usable."""
        return f"pip install '{self.info.extra}'" if self.info.extra else "pip install " + " ".join(self.info.requires)

    def properties(self, options: PluginOptions) -> dict[str, object]:
        """Return the properties declared with these options."""
        return {**self.info.properties, **options.declares()}

    def load(self) -> Any:
        """Import and return the factory.

        Raises:
            PluginError: if a requirement is missing or the import fails.
        """
        if self.factory is not None:
            return self.factory
        title = f"{self.role} '{self.info.name}'"
        if missing := self.missing:
            raise PluginError(f"{title} needs {', '.join(missing)}, which is not installed: {self.remedy}")
        module, _, attribute = self.info.factory.partition(":")
        try:
            with redirect_output():
                return getattr(import_module(module), attribute)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise PluginError(
                f"{title} of {self.distribution} {self.version} is installed but cannot be loaded from "
                f"{self.info.factory}: {one_line(error)}"
            ) from error

    def make(self, *arguments: object) -> Any:
        """Load the factory and call it.

        Raises:
            PluginError: if it fails.
            CdprError: if it raises one.
        """
        factory = self.load()
        try:
            with redirect_output():
                created = factory(*arguments)
                self._reject_old_names(created)
                return with_arrays(created, self.info.columns, arguments)
        except (CdprError, KeyboardInterrupt):
            raise
        except BaseException as error:
            where = self.place(error)
            raise PluginError(f"{self.role} '{self.info.name}' cannot be created: {one_line(error)}{where}") from error

    def _reject_old_names(self, created: Any) -> None:
        for old, new in RENAMED_METHODS.items() if self.role == "backend" else ():
            if callable(getattr(type(created), old, None)):
                with contextlib.suppress(Exception):
                    created.close()
                raise PluginError(f"backend '{self.info.name}': method '{old}' is not used: rename it to '{new}'")

    @property
    def file(self) -> str | None:
        """File of its code, after the import."""
        return getattr(sys.modules.get(self.info.factory.partition(":")[0]), "__file__", None)

    def place(self, error: BaseException) -> str:
        """Return " (FILE:LINE)" if an error was raised in or passed through the code of the plugin."""
        place = innermost(error, [self.file])
        return "" if place is None else f" ({os.path.basename(self.file or '')}:{place.tb_lineno})"

    def read_options(self, values: Mapping[str, object]) -> PluginOptions:
        """Return checked options from plain values.

        Raises:
            PluginError: if they are invalid.
        """
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
    """All plugins by role and name, and problems of the search.

    `broken` has the problems of packages whose plugins are unknown, by their names.
    """

    plugins: dict[Role, dict[str, Registered]] = field(default_factory=lambda: {role: {} for role in ROLES})
    problems: list[str] = field(default_factory=list)
    broken: dict[tuple[str, str], str] = field(default_factory=dict)

    def names(self, role: Role) -> list[str]:
        """Return the names for `role` in scenarios, sorted."""
        return sorted(self.plugins[role])

    def get(self, role: Role, name: str) -> Registered:
        """Return the plugin with this name or alias.

        If packages could not be loaded, their reasons are added, first that of a package with a similar name.

        Raises:
            PluginError: if there is none, with the nearest and all names.
        """
        found = self.plugins[role].get(name) or self._by_alias(role, name)
        if found is not None:
            return found
        for names, problem in self.broken.items():
            if _bare(name) in map(_bare, names):
                raise PluginError(f"{role} '{name}' cannot be loaded: {problem}")
        text = unknown(role, name, self.names(role))
        if self.broken:
            text += "; not loaded, so their plugins are unknown: " + "; ".join(self.broken.values())
        raise PluginError(text)

    def declared(self, role: Role, item: type) -> Mapping[str, object]:
        """Return the properties declared by a class or its nearest base, as a plugin or by `properties`."""
        entries = self.plugins[role].values()
        for each in item.__mro__:
            for entry in entries:
                if each is entry.factory or f"{each.__module__}:{each.__qualname__}" == entry.info.factory:
                    return entry.info.properties
            if isinstance(own := vars(each).get("properties"), Mapping):
                return own
        return {}

    def with_class(self, role: Role, item: object, distribution: str = "", version: str = "") -> tuple[Registry, str]:
        """Return a copy with a class that is not installed, and its name there.

        Raises:
            PluginError: if it is no class of this role, or its name is in use.
        """
        info = describe_class(role, item)
        assert isinstance(item, type)
        entry = Registered(role, info, distribution or item.__module__, version or source_version(item), item)
        names = self.plugins[role]
        other = names.get(info.name)
        known = None if other is None else (other.distribution, other.version)
        if known not in (None, (entry.distribution, entry.version)):
            where = "" if not distribution else f"{distribution}: "
            raise PluginError(f"{where}class {info.name}: a {role} of this name already exists; choose another name")
        return replace(self, plugins={**self.plugins, role: {**names, info.name: entry}}), info.name

    def _by_alias(self, role: Role, name: str) -> Registered | None:
        """Return the first plugin, by name, with the alias `name`."""
        entries = (self.plugins[role][each] for each in self.names(role))
        return next((entry for entry in entries if name in entry.info.aliases), None)

    def add(self, role: Role, info: PluginInfo, distribution: str, version: str) -> None:
        """Register one plugin. A name conflict favours the built-in plugin; the other becomes `distribution:name`."""
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


def with_arrays(plugin: Any, columns: tuple[Column, ...], arguments: Sequence[Any]) -> Any:
    """Return a plugin, created with these arguments, with arrays for its columns for use outside simulations."""
    if columns:
        import numpy as np  # not needed to list plugins

        robot = arguments[0]
        plugin.log({column.name: np.full(column.width or robot.m, np.nan) for column in columns})
    return plugin


def _found(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):  # its parent package is missing
        return False


def _bare(name: str) -> str:
    """Return a name without the usual variations: case, - and _, and the prefix cdpr."""
    return name.lower().replace("_", "-").removeprefix("cdpr-")


def unknown(role: Role, name: str, names: list[str]) -> str:
    """Return the error text for an unknown name."""
    known = f"installed are {', '.join(names)} (see 'cdpr plugins'; --plugin FILE adds your own)"
    several = "'cdpr compare' runs all; " if role == "backend" and name == "all" else ""
    return f"no {role} is named '{name}': {several or did_you_mean(name, names)}{known}"


_files: tuple[PluginFile, ...] = ()


def plugin_files() -> tuple[PluginFile, ...]:
    """Return the files with plugins that this process uses in addition to installed ones."""
    return _files


def use_files(files: Sequence[PluginFile | str]) -> None:
    """Use the plugins in exactly these files, in addition to installed ones.

    Raises:
        PluginError: if one is broken.
    """
    global _files
    with redirect_output():
        read = tuple(read_file(file) if isinstance(file, str) else file for file in files)
    before, _files = _files, read
    if before != read:
        registry.cache_clear()
    try:
        registry()
    except PluginError:
        _files = before
        registry.cache_clear()
        raise


@lru_cache(maxsize=1)
def registry() -> Registry:
    """Return the plugins of the installed distributions and of `plugin_files`; searched once per process."""
    problems: list[str] = []
    found = collect(_entry_points(problems), disabled=bool(os.environ.get(DISABLE)))
    found.problems[:0] = problems
    for file in _files:
        with redirect_output():
            items = list(classes_of(file))
        for item in items:
            found, _ = found.with_class(role_of(item), item, file.name, file.version)
    return found


def _entry_points(problems: list[str]) -> Iterator[importlib.metadata.EntryPoint]:
    """Yield the entry points of each distribution, the first of a name on the path.

    A damaged one does not affect others. `importlib.metadata.entry_points` raises for any damaged entry point, of any
    group, without naming it. Names of distributions come from their file names, as there, because reading all metadata
    takes a sixth of a second.
    """
    seen: set[str] = set()
    for distribution in importlib.metadata.distributions():
        try:
            name = getattr(distribution, "_normalized_name", None) or distribution.metadata["Name"]
            if name in seen:
                continue
            if GROUP not in (distribution.read_text("entry_points.txt") or ""):
                seen.add(name)
                continue  # before parsing, which takes twice as long
            points = [point for point in distribution.entry_points if point.group == GROUP]
            if points:
                metadata = distribution.metadata
                if None in (metadata["Name"], metadata["Version"]):
                    raise ValueError("no name and version")
        except Exception as error:
            place = getattr(distribution, "_path", None) or "a distribution"
            problems.append(f"{place}: its entry points cannot be read: {one_line(error)}")
            continue
        seen.add(name)
        yield from points


def collect(entry_points: Iterable[importlib.metadata.EntryPoint], *, disabled: bool = False) -> Registry:
    """Return a registry. A failing plugin is omitted and reported; it does not affect the others.

    Built-in plugins come first and the others in the order of distribution and name, so that the result does not depend
    on the path. With `disabled`, third-party plugins are not even imported.
    """
    result = Registry()
    points = []
    for found, group in groupby(entry_points, attrgetter("dist")):
        named = (found.name, found.version) if found else ("unknown", "?")  # each access parses its metadata
        points += [(*named, point) for point in group]
    points.sort(key=lambda row: (row[0] != OWN_DISTRIBUTION, row[0], row[2].name))
    for distribution, version, point in points:
        if disabled and distribution != OWN_DISTRIBUTION:
            continue
        try:
            with redirect_output():
                rows = _rows(point)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            problem = f"{distribution} {version}, entry point '{point.name}': {one_line(error)}"
            result.problems.append(problem)
            result.broken[distribution, point.name] = problem
            continue
        for role, info in rows:
            result.add(role, info, distribution, version)
    return result


def _rows(point: importlib.metadata.EntryPoint) -> list[tuple[Role, PluginInfo]]:
    """Load one entry point and call all its hooks."""
    manager = pluggy.PluginManager("cdpr")
    manager.add_hookspecs(Hooks)
    plugin = point.load()
    manager.register(plugin)
    manager.check_pending()  # a misspelt hook is an error
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
        raise PluginError(
            "it implements no hook: cdpr_backends, cdpr_controllers, cdpr_solvers or cdpr_estimators (marked @hookimpl)"
        )
    return rows
