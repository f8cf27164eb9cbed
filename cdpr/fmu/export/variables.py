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

Causality = Literal["independent", "parameter", "input", "output", "constant"]


@dataclass(frozen=True)
class Variable:
    """A variable; the C source knows it by its name.

    Attributes:
        causality: as in FMI; a constant is hidden from the host.
        shape: () for a scalar.
        unit: that of all its numbers, "" for numbers without unit.
        values: start values, as many as the shape says, row by row; zeros for what is calculated.
        direct: an output that depends on inputs at the same instant.
        least: what none of its numbers should be below, None where any may be.
    """

    name: str
    causality: Causality
    shape: tuple[int, ...]
    unit: str
    values: tuple[float, ...]
    description: str
    direct: bool = False
    least: float | None = None

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

    @abstractmethod
    def variables(self) -> list[Variable]:
        """All variables in the order of their value references: the number of the numbers before them."""


def parameter(
    name: str, shape: tuple[int, ...], unit: str, values: Sequence[float] | Array, description: str
) -> Variable:
    """Return a parameter, which a host may set until the end of the initialization."""
    return Variable(name, "parameter", shape, unit, tuple(np.ravel(values).tolist()), description)


def entrance(
    name: str,
    size: int,
    unit: str,
    description: str,
    values: Sequence[float] | Array | None = None,
    least: float | None = None,
) -> Variable:
    """Return an input; it starts at zero unless said."""
    start = np.zeros(size) if values is None else np.asarray(values)
    return Variable(name, "input", (size,), unit, tuple(start.tolist()), description, least=least)


def output(name: str, size: int, unit: str, description: str, direct: bool = False) -> Variable:
    """Return an output."""
    return Variable(name, "output", (size,), unit, (0.0,) * size, description, direct)
