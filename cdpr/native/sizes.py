"""Symbolic dimensions of kernel arrays: sums of products of sizes and integers, such as "2*m + 1"."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod


class Dimension:
    """Length of an array along one axis.

    Attributes:
        text: As declared, such as "2*m + 1".
        symbol: The size that it is, such as "m"; None where it is an expression or an integer.
        symbols: The names of the sizes in it.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.symbol = text if text.isidentifier() else None
        self._terms = [[factor.strip() for factor in term.split("*")] for term in text.split("+")]
        self.symbols = frozenset(factor for term in self._terms for factor in term if not factor.isdigit())
        self._length = None if self.symbols else self.evaluate({})

    def evaluate(self, sizes: Mapping[str, int]) -> int:
        """Return the length for given sizes."""
        if self.symbol is not None:
            return sizes[self.symbol]
        return sum(prod(int(word) if word.isdigit() else sizes[word] for word in term) for term in self._terms)

    def allows(self, length: int) -> bool:
        """Return whether an array may have this length for some sizes."""
        return self._length is None or self._length == length
