"""Finds the variables of an FMU that have one name: an array, or a family of scalars."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cdpr.fmu.model import REALS, Element, ModelDescription, Variable

PATTERNS = ("{}[{}]", "{}_{}", "{}{}")  # name and number
PARTS = ("{}.{}", "{}_{}", "{}[{}]")  # name and component, such as x
NUMBERED = re.compile(r"\{(i0?)\}")


@dataclass(frozen=True)
class Candidate:
    """Elements that may be a signal, in the order of the FMU's numbers."""

    name: str
    elements: tuple[Element, ...]
    by_component: bool = False  # named x, y, z, ...: their order needs no telling


def elements_of(variable: Variable, name: str = "") -> tuple[Element, ...]:
    """All elements of a variable, row by row."""
    if not variable.shape:
        return (Element(variable, 0, name or variable.name),)
    places: list[tuple[int, ...]] = [()]
    for size in variable.shape:
        places = [(*place, i) for place in places for i in range(1, size + 1)]
    return tuple(
        Element(variable, index, f"{name or variable.name}[{','.join(map(str, place))}]")
        for index, place in enumerate(places)
    )


class Finder:
    """Looks among the real variables of an FMU that have one of `causalities`."""

    def __init__(self, description: ModelDescription, causalities: Sequence[str]) -> None:
        self.variables = {
            name: variable
            for name, variable in description.by_name.items()
            if variable.kind in REALS and variable.causality in causalities
        }

    def named(self, base: str, count: int, components: Sequence[str] = ()) -> list[Candidate]:
        """Return all that is called `base` and has `count` elements; the same elements are listed once."""
        found: dict[tuple[tuple[int, int], ...], Candidate] = {}
        for candidate in self._named(base, count, components):
            key = tuple((each.variable.value_reference, each.index) for each in candidate.elements)
            found.setdefault(key, candidate)
        return list(found.values())

    def _named(self, base: str, count: int, components: Sequence[str]) -> list[Candidate]:
        found = []
        variable = self.variables.get(base)
        if variable is not None and variable.size == count and sum(size > 1 for size in variable.shape) <= 1:
            found.append(Candidate(base, elements_of(variable, base)))
        for pattern in PATTERNS:
            found += self._family(lambda i, pattern=pattern: pattern.format(base, i), count)  # type: ignore[misc]
        for pattern in PARTS if components else ():
            names = [pattern.format(base, part) for part in components]
            if scalars := self._scalars(names):
                found.append(Candidate(f"{names[0]} ... {names[-1]}", scalars, by_component=True))
        return found

    def pattern(self, pattern: str, count: int) -> list[Candidate]:
        """Return what a pattern with {i} or {i0} names, if all of it is there."""
        names = [NUMBERED.sub(lambda match: str(i + (match[1] == "i")), pattern) for i in range(count)]  # noqa: B023
        scalars = self._scalars(names)
        return [Candidate(pattern, scalars)] if scalars else []

    def _family(self, name: Callable[[int], str], count: int) -> list[Candidate]:
        """Members numbered from 0 or 1 without a gap, `count` of them and no more."""
        if count == 1 and not (name(0) in self.variables or name(1) in self.variables):
            return []
        first = 0 if name(0) in self.variables else 1
        if name(first + count) in self.variables:
            return []
        names = [name(first + i) for i in range(count)]
        scalars = self._scalars(names)
        return [Candidate(f"{names[0]} ... {names[-1]}" if count > 1 else names[0], scalars)] if scalars else []

    def _scalars(self, names: Sequence[str]) -> tuple[Element, ...] | None:
        variables = [self.variables.get(name) for name in names]
        if any(variable is None or variable.size != 1 for variable in variables):
            return None
        return tuple(
            Element(variable, 0, name) for name, variable in zip(names, variables, strict=True) if variable is not None
        )
