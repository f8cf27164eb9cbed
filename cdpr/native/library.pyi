"""Extension module of the kernel library (binder.c, bound.c)."""

from typing import Any

Entry = tuple[str, int, str, tuple[str, ...]]  # name, address, fields and their types, as of `table.h`

compiler: str
sources: str  # as `cdpr.native.sources.digest`

def address(array: object, /) -> int: ...
def fill(kind: type, words: bytes, about: bytes, shapes: bytes, arrays: tuple[object, ...], /) -> bytes | None: ...
def tables() -> tuple[tuple[str, tuple[Entry, ...]], ...]: ...

class Bound:
    name: str
    operation: int
    place: int
    words: bytes
    given: dict[str, Any]
    arrays: tuple[object, ...]

    def __new__(cls, operation: int, words: bytes, given: dict[str, Any], arrays: object) -> Bound: ...
    def __call__(self, time: float = 0.0, /) -> int: ...
    def on(self, positions: bytes, /, *arrays: object) -> int: ...
    def unlocked(self, time: float = 0.0, /) -> int: ...
