"""Extension module of the kernel library (binder.c)."""

from typing import Any

Shape = tuple[str, ...]
Field = tuple[str, str, str, Shape]  # name, type, role, shape
Entry = tuple[str, int, int, tuple[Field, ...]]  # name, address, size of the struct in bytes, fields

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
