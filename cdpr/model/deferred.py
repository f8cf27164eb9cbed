"""What numba is told of when it first compiles what calls it."""

from __future__ import annotations

from functools import cached_property
from importlib import import_module
from typing import Any


class Deferred:
    """What compiled code calls, and no other: numba is told of it when the first kernel that does so is compiled.

    `make` is a function of `cdpr.model.numba_calls`, called with the others.
    """

    def __init__(self, make: str, *given: object) -> None:
        self._make, self._given = make, given

    @cached_property
    def _numba_type_(self) -> Any:
        made = import_module("cdpr.model.numba_calls")
        return made.type_of(getattr(made, self._make)(*self._given))

    def __call__(self, *_: object) -> Any:
        """Do nothing: it is not for Python."""
        raise TypeError("only compiled code calls this")
