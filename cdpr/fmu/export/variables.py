"""The variables of an exported plant: the one object that model description and configuration are written from."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.program import Program

Causality = Literal["independent", "parameter", "input", "output", "constant"]


@dataclass(frozen=True)
class Variable:
    """A variable; the C++ source finds it by its name.

    Attributes:
        causality: as in FMI; a constant is hidden from the host.
        shape: () for a scalar.
        unit: that of all its numbers, "" for numbers without unit.
        values: start values, as many as the shape says, row by row; zeros for what is calculated.
        direct: the inputs that an output depends on at the same instant; None for all.
        initial: of an output, the parameters and inputs that it depends on before the first step; None for all.
        least: what none of its numbers should be below, None where any may be.
        most: what none of them should exceed, likewise.
        nominal: a usual size of theirs, by which hosts scale errors; None for 1.
        tunable: a parameter that a host may change between steps, too.
        terminal: name of the terminal that it belongs to, "" for none.
    """

    name: str
    causality: Causality
    shape: tuple[int, ...]
    unit: str
    values: tuple[float, ...]
    description: str
    direct: tuple[str, ...] | None = ()
    initial: tuple[str, ...] | None = None
    least: float | None = None
    most: float | None = None
    nominal: float | None = None
    tunable: bool = False
    terminal: str = ""

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return math.prod(self.shape)


class Model(ABC):
    """What can be exported.

    Attributes:
        physics_step: step of the integrator, s.
    """

    robot: Robot
    physics_step: float

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the model."""

    @property
    @abstractmethod
    def description(self) -> str:
        """One line on it."""

    @property
    def differentiable(self) -> bool:
        """Whether it offers directional derivatives."""
        return False

    def sources(self) -> dict[str, bytes]:
        """C++ files by name that it needs beyond those of all, or instead of them."""
        return {}

    @abstractmethod
    def program(self) -> Program:
        """Arrays and operations beside the variables."""

    @abstractmethod
    def variables(self) -> list[Variable]:
        """All variables in the order of their value references: the number of the numbers before them."""


def parameter(
    name: str,
    shape: tuple[int, ...],
    unit: str,
    values: Sequence[float] | Array,
    description: str,
    tunable: bool = True,
    least: float | None = None,
    nominal: float | None = None,
) -> Variable:
    """Return a parameter, which a host may set until the end of the initialization; a tunable one, between steps."""
    start = tuple(np.ravel(values).tolist())
    return Variable(name, "parameter", shape, unit, start, description, least=least, nominal=nominal, tunable=tunable)


def entrance(
    name: str,
    size: int,
    unit: str,
    description: str,
    values: Sequence[float] | Array | None = None,
    *,
    least: float | None = None,
    most: float | None = None,
    nominal: float | None = None,
    terminal: str = "",
) -> Variable:
    """Return an input; it starts at zero unless said."""
    start = np.zeros(size) if values is None else np.asarray(values)
    values = tuple(start.tolist())
    return Variable(
        name,
        "input",
        (size,),
        unit,
        values,
        description,
        least=least,
        most=most,
        nominal=nominal,
        terminal=terminal,
    )


def output(
    name: str,
    size: int,
    unit: str,
    description: str,
    *,
    direct: Sequence[str] | None = (),
    initial: Sequence[str] | None = None,
    least: float | None = None,
    nominal: float | None = None,
    terminal: str = "",
) -> Variable:
    """Return an output."""
    return Variable(
        name,
        "output",
        (size,),
        unit,
        (0.0,) * size,
        description,
        None if direct is None else tuple(direct),
        None if initial is None else tuple(initial),
        least=least,
        nominal=nominal,
        terminal=terminal,
    )
