"""Search for the variables of an FMU with one name: an array, or a family of scalars."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from cdpr.fmu.read.model import REALS, Element, ModelDescription

PATTERNS = ("{}[{}]", "{}_{}", "{}{}")  # name and number
PARTS = ("{}.{}", "{}_{}", "{}[{}]")  # name and component, such as x
NUMBERED = re.compile(r"\{(i0?)\}")


@dataclass(frozen=True)
class Candidate:
    """Possible elements of a signal, in the order of the FMU's numbers or of the names of their components."""

    elements: tuple[Element, ...]

    @property
    def name(self) -> str:
        """Return the name for messages."""
        first, last = self.elements[0], self.elements[-1]
        if self.elements == first.variable.elements:
            return first.variable.name
        return f"{first.name} ... {last.name}"


def unique(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Return the candidates without duplicates."""
    found: dict[tuple[tuple[int, int], ...], Candidate] = {}
    for candidate in candidates:
        key = tuple((each.variable.value_reference, each.index) for each in candidate.elements)
        found.setdefault(key, candidate)
    return list(found.values())


class Finder:
    """Search among the real variables of an FMU with one of `causalities`."""

    def __init__(
        self, description: ModelDescription, causalities: Sequence[str], members: dict[str, str] | None = None
    ) -> None:
        """Search among `members`, the variables of a terminal by name, in place of all variables, if given."""
        names = {name: name for name in description.by_name} if members is None else members
        self.variables = {
            name: variable
            for name, own in names.items()
            if (variable := description.by_name.get(own)) is not None
            and variable.kind in REALS
            and variable.causality in causalities
        }

    def named(self, base: str, count: int, components: Sequence[str] = ()) -> list[Candidate]:
        """Return all candidates with the name `base` and `count` elements."""
        found = []
        variable = self.variables.get(base)
        if variable is not None and variable.size == count and sum(size > 1 for size in variable.shape) <= 1:
            found.append(Candidate(variable.elements))
        for pattern in PATTERNS:
            found += self._family(lambda i, pattern=pattern: pattern.format(base, i), count)  # type: ignore[misc]
        for pattern in PARTS if components else ():
            names = [pattern.format(base, part) for part in components]
            if scalars := self._scalars(names):
                found.append(Candidate(scalars))
        return unique(found)

    def pattern(self, pattern: str, count: int) -> list[Candidate]:
        """Return the candidates of a pattern with {i} or {i0}, if all elements exist."""
        names = [NUMBERED.sub(lambda match: str(i + (match[1] == "i")), pattern) for i in range(count)]  # noqa: B023
        scalars = self._scalars(names)
        return [Candidate(scalars)] if scalars else []

    def _family(self, name: Callable[[int], str], count: int) -> list[Candidate]:
        """Return the members numbered from 0 or 1 without a gap, if there are exactly `count`."""
        if count == 1 and not (name(0) in self.variables or name(1) in self.variables):
            return []
        first = 0 if name(0) in self.variables else 1
        if name(first + count) in self.variables:
            return []
        names = [name(first + i) for i in range(count)]
        scalars = self._scalars(names)
        return [Candidate(scalars)] if scalars else []

    def _scalars(self, names: Sequence[str]) -> tuple[Element, ...] | None:
        variables = [self.variables.get(name) for name in names]
        if any(variable is None or variable.size != 1 for variable in variables):
            return None
        return tuple(Element(variable, 0) for variable in variables if variable is not None)
