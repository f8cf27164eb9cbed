"""Fast formatting of numbers as lines of CSV, identical to `repr`.

`repr` writes the shortest decimal number that parses to the same float, which takes half a microsecond. The compiled
JSON writer of pydantic finds the same digits and formats most numbers identically.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_json

from cdpr.model.robot import Array

ROWS = 128  # rows at a time: their numbers and text fit into the cache, which halves the time

# Magnitudes with a one-digit exponent in JSON and two digits in `repr`, and other magnitudes with different formats.
_ONE_DIGIT = (1e-9, 1e-5)
_OTHERWISE = ((1e-5, 1e-4), (1e16, np.inf))


def csv_lines(rows: Array) -> bytes:
    """Return one line per row (n, width), with numbers as in `repr`."""
    lines = _fast if _is_repr() else _format_exactly
    return b"".join([lines(rows[first : first + ROWS]) for first in range(0, len(rows), ROWS)])


def _format_exactly(rows: Array) -> bytes:
    return "".join([",".join(map(repr, row)) + "\n" for row in rows.tolist()]).encode()


def _fast(rows: Array) -> bytes:
    if not rows.size:
        return b"\n" * len(rows)
    table: list[list[Any]] = rows.tolist()
    size = np.abs(rows)
    otherwise = ~np.isfinite(size)
    for limits in _OTHERWISE:
        otherwise |= _within(size, limits)
    one_digit = _within(size, _ONE_DIGIT)
    numbers = to_json(rows[one_digit].tolist())[1:-1].decode().replace("e-", "e-0").split(",")
    for i, j, number in zip(*_places(one_digit), numbers, strict=False):
        table[i][j] = number
    for i, j in zip(*_places(otherwise), strict=True):
        table[i][j] = repr(table[i][j])
    return to_json(table)[2:-2].replace(b"],[", b"\n").replace(b'"', b"") + b"\n"


def _within(size: Array, limits: tuple[float, float]) -> NDArray[np.bool_]:
    low, high = limits
    return (size >= low) & (size < high)


def _places(chosen: NDArray[np.bool_]) -> tuple[list[int], list[int]]:
    i, j = np.nonzero(chosen)
    return i.tolist(), j.tolist()


@cache
def _is_repr() -> bool:
    """Return True if pydantic formats all other numbers as `repr` does, tested with one of each kind and magnitude."""
    sizes = np.array([1.0, 1.2345678901234567, 9.5]) * 10.0 ** np.arange(-320, 308)[:, None]
    kinds = [np.nan, np.inf, -np.inf, 0.0, -0.0, 5e-324, 10.00001, 1.7976931348623157e308]
    probes = np.concatenate([sizes.ravel(), -sizes.ravel(), kinds])[:, None]
    return _fast(probes) == _format_exactly(probes)
