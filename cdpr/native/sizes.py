"""Symbolic dimensions of kernel arrays: sums of products of sizes and integers, such as "2*m + 1"."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod


def factors(dimension: str) -> list[list[str]]:
    """Split a dimension into the factors of its terms: "2*m + 1" into [["2", "m"], ["1"]]."""
    return [[factor.strip() for factor in term.split("*")] for term in dimension.split("+")]


def symbols(dimension: str) -> set[str]:
    """Return the names of the sizes in a dimension."""
    return {factor for term in factors(dimension) for factor in term if not factor.isdigit()}


def evaluate(dimension: str, sizes: Mapping[str, int]) -> int:
    """Return the value of a dimension.

    Raises:
        KeyError: A size is unknown.
    """
    return sum(
        prod(int(factor) if factor.isdigit() else sizes[factor] for factor in term) for term in factors(dimension)
    )
