"""Plugins that are not installed: a class passed to `simulate`, or the classes of a file given by --plugin.

A class that derives from an interface becomes a plugin with its own name. It may provide the data of `PluginInfo`: its
docstring begins with the summary, `properties` is a mapping of declared properties, `columns` are its columns,
`Options` is the model of its options, and `changeable` lists the options that may change during a run.
"""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any

from cdpr.base.errors import PluginError
from cdpr.base.problems import short_repr
from cdpr.plugins.info import PluginInfo, PluginOptions, Role


@dataclass(frozen=True)
class PluginFile:
    """File with plugins and its text when it was read; workers receive the text, even if the file changes."""

    path: str
    text: str

    @property
    def name(self) -> str:
        """File name in the record of a run, without folder."""
        return Path(self.path).name

    @property
    def version(self) -> str:
        """Hash of its content."""
        return fingerprint(self.text)


def fingerprint(text: str) -> str:
    """Return a hash as the version of code that has none."""
    return f"sha256:{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def read_file(path: str) -> PluginFile:
    """Read a file with plugins.

    Raises:
        PluginError: if it cannot be read or is broken.
    """
    try:
        file = PluginFile(path, Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not UTF-8"
        raise PluginError(f"--plugin {path}: {reason}; expected a Python file with classes") from error
    classes_of(file)
    return file


@lru_cache
def classes_of(file: PluginFile) -> tuple[type, ...]:
    """Execute a file and return its classes that derive from an interface.

    Raises:
        PluginError: if it fails, with the line, or has no such class and adds no part to the loop.
    """
    before = _parts_of_others()
    name = f"cdpr_file_{file.version.partition(':')[2]}_{Path(file.path).stem}"
    module = ModuleType(name)
    module.__file__ = str(Path(file.path).absolute())
    sys.modules[name] = module  # looked up there by dataclasses, pickle and kernels
    try:
        exec(compile(file.text, module.__file__, "exec", dont_inherit=True), module.__dict__)
    except SyntaxError as error:
        raise PluginError(f"{file.path}:{error.lineno or 1}: SyntaxError: {error.msg}") from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        place = innermost(error, [module.__file__])
        line = 1 if place is None else place.tb_lineno
        raise PluginError(f"{file.path}:{line}: {type(error).__name__}: {' '.join(str(error).split())}") from error
    found = tuple(
        item
        for item in vars(module).values()
        if isinstance(item, type) and item.__module__ == name and not inspect.isabstract(item) and _roles(item)
    )
    if not found and _parts_of_others() == before:
        abstract = [item for item in vars(module).values() if isinstance(item, type) and inspect.isabstract(item)]
        own = [f"; {_lacks(item)}" for item in abstract if item.__module__ == name and _roles(item)]
        raise PluginError(
            f"{file.path}: contains no class that derives from cdpr.plugins.Controller, TensionSolver, "
            f"Estimator or Backend{''.join(own)}, and adds no part to the loop (LOOP_PARTS of "
            "cdpr.simulation.loop_parts)"
        )
    return found


def _parts_of_others() -> list[object]:
    """Return the parts that plugin files added to the loop; none if its module is not imported."""
    parts: list[object] = []
    for entry in getattr(sys.modules.get("cdpr.simulation.loop_parts"), "LOOP_PARTS", ()):
        named = entry
        while isinstance(named, partial):
            named = named.func
        if not str(getattr(named, "__module__", "")).startswith("cdpr."):
            parts.append(entry)
    return parts


def innermost(error: BaseException, files: Collection[str | None] | None = None) -> TracebackType | None:
    """Return the innermost traceback entry of an error, in `files` unless they are None."""
    found, trace = None, error.__traceback__
    while trace is not None:
        if files is None or trace.tb_frame.f_code.co_filename in files:
            found = trace
        trace = trace.tb_next
    return found


def role_of(item: type) -> Role:
    """Return the role of a class from a file."""
    return _roles(item)[0]


def describe_class(role: Role, item: Any) -> PluginInfo:
    """Return the PluginInfo of a class.

    Raises:
        PluginError: if it cannot be a plugin of this role.
    """
    if not isinstance(item, type) or role not in _roles(item):
        hint = "; give the class, and its options as overrides" if _roles(type(item)) else ""
        raise PluginError(
            f"{role}: expected a name or a class derived from cdpr.plugins.{_interfaces()[role].__name__}, "
            f"got {short_repr(item)}{hint}"
        )
    if inspect.isabstract(item):
        raise PluginError(f"{role}: {_lacks(item)}")
    try:
        return PluginInfo(
            name=item.__name__,
            factory=f"{item.__module__}:{item.__qualname__}",
            summary=(inspect.getdoc(item) or item.__name__).partition("\n")[0],
            properties=getattr(item, "properties", {}),
            options=getattr(item, "Options", PluginOptions),
            columns=getattr(item, "columns", ()),
            changeable=getattr(item, "changeable", ()),
        )
    except (TypeError, ValueError) as error:
        raise PluginError(f"{role} {item.__name__}: {error}") from error


def source_version(item: type) -> str:
    """Return a hash of the source of a class; "unknown" if there is none, such as for interactive code."""
    try:
        return fingerprint(inspect.getsource(item))
    except (OSError, TypeError):
        return "unknown"


def _interfaces() -> dict[Role, type]:
    from cdpr.plugins.backend import Backend
    from cdpr.plugins.controller import Controller
    from cdpr.plugins.estimator import Estimator
    from cdpr.plugins.solver import TensionSolver

    return {"backend": Backend, "controller": Controller, "solver": TensionSolver, "estimator": Estimator}


def _roles(item: type) -> list[Role]:
    return [role for role, interface in _interfaces().items() if issubclass(item, interface)]


def _lacks(item: type) -> str:
    missing: Iterator[str] = iter(sorted(getattr(item, "__abstractmethods__", ())))
    return f"class {item.__name__} lacks {', '.join(missing)}"
