"""Description of a plugin, and the hooks that return descriptions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import pluggy
from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema
from pydantic_core.core_schema import with_info_after_validator_function

from cdpr.base.column import Column
from cdpr.base.columns import check_declared
from cdpr.base.problems import short_repr

INTERFACE_VERSION = 1

Role = Literal["backend", "controller", "solver", "estimator"]

hookspec = pluggy.HookspecMarker("cdpr")
hookimpl = pluggy.HookimplMarker("cdpr")


class FileName(str):
    """Type of options with a file name; relative names refer to the folder of the scenario.

    Attributes:
        path: the file.

    Example:
        >>> from cdpr.plugins import FileName, PluginOptions
        >>> class Options(PluginOptions):
        ...     file: FileName
        >>> Options.model_validate({"file": "gains.csv"}, context={"folder": "/data"}).file.path.as_posix()
        '/data/gains.csv'
    """

    path: Path

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Accept a text; the loader provides the folder as context."""
        return with_info_after_validator_function(cls._located, handler(str))

    @classmethod
    def _located(cls, name: str, info: ValidationInfo) -> FileName:
        created = cls(name)
        created.path = Path(os.path.abspath((info.context or {}).get("folder", "")), name)
        return created


class PluginOptions(BaseModel):
    """Base class of a plugin's options in a scenario: frozen, no unknown key, no NaN.

    Example:
        >>> from cdpr.plugins import PluginOptions
        >>> class Options(PluginOptions):
        ...     kp: float = 100.0
        >>> Options(kp=50.0).kp
        50.0
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)

    def declares(self) -> Mapping[str, object]:
        """Return the declared properties that differ with these options."""
        return {}


@dataclass(frozen=True)
class PluginInfo:
    """Description of one backend, controller, solver or estimator.

    Attributes:
        name: name in scenarios.
        factory: "module:Class", imported only when the plugin is used.
        summary: one line.
        requires: names of the required importable modules.
        extra: pip extra that installs them, such as "cdpr[mujoco]".
        properties: declared properties (a backend's order, a solver's continuity, ...) with default options (see
            `PluginOptions.declares`), shown by `cdpr plugins` and checked by the conformance kit.
        options: model of its options.
        interface: interface version.
        aliases: other established names, each with its source; valid in scenarios if no plugin has that name.
        columns: additional quantities of a run; the plugin receives their arrays through its method `log`.
        changeable: options that may change between two steps; the plugin receives them through its method `change`.

    Example:
        >>> from cdpr.plugins import PluginInfo
        >>> info = PluginInfo(name="mine", factory="my_package.solver:Mine", summary="least norm")
        >>> info.name, info.interface
        ('mine', 1)
    """

    name: str
    factory: str
    summary: str
    requires: tuple[str, ...] = ()
    extra: str = ""
    properties: Mapping[str, object] = field(default_factory=dict)
    options: type[PluginOptions] = PluginOptions
    interface: int = INTERFACE_VERSION
    aliases: Mapping[str, str] = field(default_factory=dict)
    columns: tuple[Column, ...] = ()
    changeable: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check the attributes, so that errors occur here and not in the list of all plugins."""
        for name in ("name", "factory", "summary", "extra"):
            if not isinstance(getattr(self, name), str):
                raise TypeError(f"PluginInfo.{name} must be a text, got {short_repr(getattr(self, name))}")
        if not self.name or ":" not in self.factory:
            raise ValueError(
                "a plugin needs a name and a factory 'module:Class', got "
                f"{short_repr(self.name)}, {short_repr(self.factory)}"
            )
        if isinstance(self.requires, str) or not all(isinstance(module, str) for module in self.requires):
            raise TypeError(f"PluginInfo.requires must be a tuple of module names, got {short_repr(self.requires)}")
        if not isinstance(self.properties, Mapping):
            raise TypeError(f"PluginInfo.properties must be a mapping, got {short_repr(self.properties)}")
        if not isinstance(self.aliases, Mapping):
            raise TypeError(f"PluginInfo.aliases must be a mapping of names to sources, got {short_repr(self.aliases)}")
        check_declared(self.columns)
        if not (isinstance(self.options, type) and issubclass(self.options, PluginOptions)):
            raise TypeError(
                f"the options of plugin '{self.name}' must derive from cdpr.plugins.PluginOptions, which rejects "
                f"unknown keys, got {short_repr(self.options)}"
            )
        known = [field.alias or name for name, field in self.options.model_fields.items()]
        if not isinstance(self.changeable, tuple) or any(name not in known for name in self.changeable):
            raise ValueError(
                f"PluginInfo.changeable of '{self.name}' must be a tuple of its options, {', '.join(known) or 'none'}, "
                f"got {short_repr(self.changeable)}"
            )


class Hooks:
    """Hooks of cdpr.

    Example:
        >>> from cdpr.plugins import PluginInfo, hookimpl
        >>> @hookimpl
        ... def cdpr_solvers():
        ...     return [PluginInfo(name="mine", factory="my_package.solver:Mine", summary="least norm")]
        >>> [info.name for info in cdpr_solvers()]
        ['mine']
    """

    @hookspec
    def cdpr_backends(self) -> list[PluginInfo]:
        """Return the physics backends of this package."""
        raise AssertionError("a hook specification is never called")

    @hookspec
    def cdpr_controllers(self) -> list[PluginInfo]:
        """Return the controllers of this package."""
        raise AssertionError("a hook specification is never called")

    @hookspec
    def cdpr_solvers(self) -> list[PluginInfo]:
        """Return the tension solvers of this package."""
        raise AssertionError("a hook specification is never called")

    @hookspec
    def cdpr_estimators(self) -> list[PluginInfo]:
        """Return the estimators of this package."""
        raise AssertionError("a hook specification is never called")
