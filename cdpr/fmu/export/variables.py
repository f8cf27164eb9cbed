"""Variables of an exported model, the common source of model description and configuration."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.exported_pipeline import ExportedPipeline

Causality = Literal["independent", "parameter", "input", "output", "constant"]


@dataclass(frozen=True)
class Variable:
    """Variable; the C++ source finds it by its name.

    Attributes:
        causality: causality of the standard; a constant is hidden from the host.
        shape: shape, () for a scalar.
        unit: unit of all its numbers, "" for numbers without unit.
        values: start values in the number of the shape, row by row; zeros for calculated variables.
        direct: inputs that affect an output at the same instant; None for all.
        initial: parameters and inputs that affect an output before the first step; None for all.
        least: lower limit of its numbers; None without limit.
        most: upper limit, likewise.
        nominal: typical value, by which hosts scale errors; None for 1.
        tunable: True for a parameter that a host may also change between steps.
        terminal: name of its terminal, "" for none.
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
        """Return the number of its numbers."""
        return math.prod(self.shape)


class Model(ABC):
    """Model that can be exported.

    Attributes:
        physics_step: step of the integrator, s.
    """

    robot: Robot
    physics_step: float

    @property
    @abstractmethod
    def name(self) -> str:
        """Return the name of the model."""

    @property
    @abstractmethod
    def description(self) -> str:
        """Return one line on the model."""

    @property
    def differentiable(self) -> bool:
        """Return whether it provides directional derivatives."""
        return False

    def sources(self) -> dict[str, bytes]:
        """Return C++ files by name that extend or replace the common ones."""
        return {}

    @abstractmethod
    def pipeline(self) -> ExportedPipeline:
        """Return arrays and operations beside the variables."""

    @abstractmethod
    def variables(self) -> list[Variable]:
        """Return all variables in the order of their value references: the number of the numbers before them."""


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
    """Return a parameter, which a host may set until the end of the initialization; also between steps if tunable."""
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
    """Return an input; the default start value is zero."""
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
