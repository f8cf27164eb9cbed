"""Operations of the kernel library for the instruction set in use."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cache

VARIABLE = "CDPR_NATIVE_TARGET"


@dataclass(frozen=True)
class Field:
    """Member of an operation's struct, as `table.h` describes it."""

    name: str
    type: str
    role: str
    shape: tuple[str, ...]

    @property
    def is_array(self) -> bool:
        """Whether the struct holds an address."""
        return self.type.endswith("*")


@dataclass(frozen=True)
class Operation:
    """Compiled function `int f(void *place, double time)` and the fields of its struct."""

    name: str
    address: int
    fields: tuple[Field, ...]


def targets() -> tuple[str, ...]:
    """Return the instruction sets of the library that this processor can run, the fastest last."""
    return tuple(_tables())


def target() -> str:
    """Return the instruction set in use: the fastest, or that of the environment variable CDPR_NATIVE_TARGET.

    Raises:
        ValueError: The variable names none that this processor can run.
    """
    wanted = os.environ.get(VARIABLE)
    if wanted is None:
        return targets()[-1]
    if wanted not in targets():
        raise ValueError(f"{VARIABLE}: expected one of {', '.join(targets())}, got '{wanted}'.")
    return wanted


def operations() -> dict[str, Operation]:
    """Return the operations for the instruction set in use, by name."""
    return _tables()[target()]


@cache
def _tables() -> dict[str, dict[str, Operation]]:
    from cdpr.native import library

    return {
        target: {
            name: Operation(name, address, tuple(Field(*field) for field in fields))
            for name, address, _, fields in entries
        }
        for target, entries in library.tables()
    }
