"""Metadata of an FMU as frozen data."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import cached_property

from cdpr.base.errors import FmuError
from cdpr.base.units import Unit

REALS = ("Real", "Float64")  # types of signals: double precision in FMI 2 and 3


@dataclass(frozen=True)
class Variable:
    """Variable, scalar or array (row by row)."""

    name: str
    value_reference: int
    kind: str  # Real, Integer, ... of FMI 2; Float64, Int32, ... of FMI 3; Boolean, String, Enumeration of both
    causality: str
    variability: str
    shape: tuple[int, ...] = ()
    unit: Unit | None = None
    start: tuple[str, ...] | None = None  # one text per element, as written
    relative: bool = False  # a difference, without the unit's offset
    aliases: tuple[str, ...] = ()
    description: str = ""

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)

    @property
    def elements(self) -> tuple[Element, ...]:
        """Return all its numbers, row by row."""
        return tuple(Element(self, index) for index in range(self.size))

    @property
    def names(self) -> tuple[str, ...]:
        """Return its name and its aliases."""
        return (self.name, *self.aliases)


@dataclass(frozen=True)
class Capabilities:
    """Capabilities of the FMU in co-simulation."""

    get_set_state: bool = False
    serialize_state: bool = False
    variable_step: bool = False
    once_per_process: bool = False
    needs_tool: bool = False  # requires the tool that made it
    fixed_internal_step: float | None = None  # s


@dataclass(frozen=True)
class Element:
    """One number of a variable; `index` counts its elements row by row, from 0."""

    variable: Variable
    index: int

    @property
    def name(self) -> str:
        """Return its name, with indices from 1 for an array: x, F[2], A[1,3]."""
        places: list[str] = []
        rest = self.index
        for size in reversed(self.variable.shape):
            rest, place = divmod(rest, size)
            places.insert(0, str(place + 1))
        return self.variable.name + (f"[{','.join(places)}]" if places else "")


@dataclass(frozen=True)
class ModelDescription:
    """Metadata of an FMU for co-simulation."""

    fmi: str  # "2.0" or "3.0"
    name: str
    token: str  # guid of FMI 2, instantiationToken of FMI 3
    identifier: str
    variables: tuple[Variable, ...]
    capabilities: Capabilities = Capabilities()
    units: dict[str, Unit] = field(default_factory=dict)
    platforms: tuple[str, ...] = ()  # folders of binaries/ with a library
    sources: bool = False
    default_step: float | None = None  # s
    terminals: tuple[dict[str, str], ...] = ()  # of each terminal: variable by member name
    description: str = ""
    tool: str = ""

    @cached_property
    def by_name(self) -> dict[str, Variable]:
        """Return variables by name and alias."""
        return {name: variable for variable in self.variables for name in reversed(variable.names)} | {
            variable.name: variable for variable in self.variables
        }

    def find(self, name: str) -> Variable | Element:
        """Return the variable `name`, or the element of a name such as "x[2]" or "A[1,3]", counted from 1.

        Raises:
            FmuError: if there is none.
        """
        if name in self.by_name:
            return self.by_name[name]
        match = re.fullmatch(r"(.+)\[([0-9]{1,9}(?:, ?[0-9]{1,9})*)\]", name)
        variable = self.by_name.get(match[1]) if match else None
        if match is None or variable is None or not variable.shape:
            raise FmuError(f"the FMU has no variable '{name}'")
        place = [int(part) for part in match[2].split(",")]
        if len(place) != len(variable.shape) or not all(
            1 <= part <= size for part, size in zip(place, variable.shape, strict=True)
        ):
            shape = " x ".join(map(str, variable.shape))
            raise FmuError(f"'{name}' is not an element of {match[1]}, which is {shape}, counted from 1")
        index = 0
        for part, size in zip(place, variable.shape, strict=True):
            index = index * size + part - 1
        return Element(variable, index)
