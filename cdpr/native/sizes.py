"""Symbolic dimensions of kernel arrays: sums of products of sizes and integers, such as "2*m + 1".

A size may have a lower limit: "w >= 6".
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod


class Dimension:
    """Length of an array along one axis.

    Attributes:
        text: declaration, such as "2*m + 1" or "w >= 6".
        symbol: name of a size, such as "m"; None for an expression or an integer.
        symbols: names of the sizes in it.
        least: smallest length.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        sums, _, least = (part.strip() for part in text.partition(">="))
        self.least = int(least or 0)
        self.symbol = sums if sums.isidentifier() else None
        terms = [[factor.strip() for factor in term.split("*")] for term in sums.split("+")]
        self.symbols = frozenset(factor for term in terms for factor in term if not factor.isdigit())
        self._terms = [
            (prod(int(factor) for factor in term if factor.isdigit()), [each for each in term if not each.isdigit()])
            for term in terms
        ]
        self._length = None if self.symbols else self.evaluate({})

    def evaluate(self, sizes: Mapping[str, int]) -> int:
        """Return the length for given sizes."""
        if self.symbol is not None:
            return sizes[self.symbol]
        length = 0
        for product, symbols in self._terms:
            for symbol in symbols:
                product *= sizes[symbol]
            length += product
        return length

    def allows(self, length: int) -> bool:
        """Return whether an array may have this length for some sizes."""
        return length >= self.least and self._length in (None, length)
