"""Packages that import a name or a module of theirs when it is first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module


def lazily(package: str, homes: Mapping[str, str] = {}) -> Callable[[str], object]:
    """Return the `__getattr__` of a package: names from the modules in `homes`, and all its own modules.

    Packages define it where type checkers do not look, for they would then believe that every name exists; the same
    names stand beside it, imported `if TYPE_CHECKING`.
    """

    def get(name: str) -> object:
        if name in homes:
            return getattr(import_module(homes[name]), name)
        if not name.startswith("_"):
            module = f"{package}.{name}"
            try:
                return import_module(module)
            except ModuleNotFoundError as error:
                if error.name != module:
                    raise
        raise AttributeError(f"module '{package}' has no attribute {name!r}")

    return get
