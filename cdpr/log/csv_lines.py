"""Numbers as lines of CSV: the bytes of `repr` in a fraction of its time.

`repr` writes the shortest decimal number that is read back as the same float, and needs half a microsecond for it. The
JSON writer of pydantic, which is compiled, finds the same digits, and sets most of them in the same way.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from pydantic_core import to_json

from cdpr.model.robot import Array

# Sizes that JSON sets in another way: exponents of one digit, an exponent only from 1e-6 down, none of its signs above.
_OTHERWISE = ((1e-9, 1e-4), (1e16, np.inf))


def csv_lines(rows: Array) -> bytes:
    """Return a line for each row (n, width), each number as `repr` writes it."""
    return _fast(rows) if _is_repr() else _plain(rows)


def _plain(rows: Array) -> bytes:
    return "".join([",".join(map(repr, row)) + "\n" for row in rows.tolist()]).encode()


def _fast(rows: Array) -> bytes:
    if not rows.size:
        return b"\n" * len(rows)
    table: list[list[Any]] = rows.tolist()
    size = np.abs(rows)
    otherwise = ~np.isfinite(size)
    for low, high in _OTHERWISE:
        otherwise |= (size >= low) & (size < high)
    for i, j in zip(*(places.tolist() for places in np.nonzero(otherwise)), strict=True):
        table[i][j] = repr(table[i][j])
    return to_json(table)[2:-2].replace(b"],[", b"\n").replace(b'"', b"") + b"\n"


@cache
def _is_repr() -> bool:
    """Return whether pydantic formats all other numbers as `repr` does, tried with one of each kind and size."""
    sizes = np.array([1.0, 1.2345678901234567, 9.5]) * 10.0 ** np.arange(-320, 308)[:, None]
    kinds = [np.nan, np.inf, -np.inf, 0.0, -0.0, 5e-324, 10.00001, 1.7976931348623157e308]
    probes = np.concatenate([sizes.ravel(), -sizes.ravel(), kinds])[:, None]
    return _fast(probes) == _plain(probes)
