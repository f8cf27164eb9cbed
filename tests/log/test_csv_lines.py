"""Lines of CSV: the bytes of `repr`, for floats of all kinds."""

from __future__ import annotations

import os

import numpy as np
import pytest

from cdpr.log import csv_lines as module
from cdpr.log.csv_lines import _fast, _format_exactly, _is_repr, csv_lines

NUMBERS = int(os.environ.get("CDPR_NUMBERS", "40000"))


def samples(kind: str, n: int) -> np.ndarray:
    rng = np.random.default_rng(len(kind))
    if kind == "bits":  # every exponent, subnormal numbers, NaN
        return rng.integers(0, 2**64, n, np.uint64).view(np.float64)
    if kind == "usual":
        return rng.standard_normal(n) * 10.0 ** rng.integers(-7, 18, n)
    return np.round(rng.standard_normal(n), 3) * 10.0 ** rng.integers(-9, 19, n)  # few digits


@pytest.mark.parametrize("kind", ["bits", "usual", "short"])
def test_the_fast_way_gives_the_bytes_of_repr(kind: str) -> None:
    assert _is_repr()
    rows = samples(kind, NUMBERS // 8 * 8).reshape(-1, 8)
    assert _fast(rows) == _format_exactly(rows)


def test_edges_of_notations() -> None:
    edges = [float(f"{digits}e{exponent}") for digits in ("1", "9.999999999999999") for exponent in range(-11, 19)]
    for rows in (np.array([edges] * 300), np.array(edges)[:, None], -np.array([edges])):
        assert csv_lines(rows) == _format_exactly(rows)
    assert csv_lines(np.empty((0, 3))) == b""


def test_another_notation_of_the_library_changes_no_byte(monkeypatch: pytest.MonkeyPatch) -> None:
    json = module.to_json
    monkeypatch.setattr(module, "to_json", lambda rows, **options: json(rows, **options).replace(b"e-", b"E-"))
    _is_repr.cache_clear()
    try:
        assert not _is_repr()
        assert csv_lines(np.array([[1e-9, 1.0]])) == b"1e-09,1.0\n"
    finally:
        _is_repr.cache_clear()
