"""Start values of an FMU's parameters, from a scenario by name or from cdpr in SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import FmuError
from cdpr.base.problems import shown
from cdpr.base.units import alike, known_unit, si
from cdpr.cables import immediate
from cdpr.fmu.export import Plant
from cdpr.fmu.read.model import REALS, Element, ModelDescription, Variable
from cdpr.fmu.run.instance import Setting, Value
from cdpr.model import Robot
from cdpr.model.robot import Array

FLOATS = (*REALS, "Float32")
Known = tuple[ArrayLike, str]  # a value in SI units, and its unit


def robot_parameters(
    robot: Robot, gravity: Array, physics_step: float, state: Array, order: Sequence[int] | None
) -> dict[str, Known]:
    """Return values for parameters of robot, step and initial state (13,), by the names that cdpr exports.

    `order` holds the FMU's number, from 1, of each cable; the values are in the FMU's order.
    """
    if order is not None:
        robot = replace(robot, cables=tuple(robot.cables[i] for i in np.argsort(order)))
    return {
        variable.name: (np.reshape(variable.values, variable.shape), variable.unit)
        for variable in Plant(robot, gravity, physics_step, state, winches=not immediate(robot)).variables()
        if variable.causality == "parameter"
    }


class Parameters:
    """Values of some variables, whole arrays, initially the start values of the FMU."""

    def __init__(self, description: ModelDescription) -> None:
        self.description = description
        self._values: dict[int, list[Value]] = {}
        self._variables: dict[int, Variable] = {}

    def settings(self) -> list[Setting]:
        """Return the changed values, by value reference."""
        return [
            Setting(self._variables[reference].kind, reference, tuple(values))
            for reference, values in sorted(self._values.items())
        ]

    def give(self, values: Mapping[str, Value | Sequence[Value]]) -> None:
        """Set variables by name, in the FMU's units; an element of an array has a name like x[2].

        Raises:
            FmuError: if a name or a value is invalid.
        """
        for name, value in values.items():
            found = self.description.find(name)
            variable = found.variable if isinstance(found, Element) else found
            if variable.causality != "parameter":
                raise FmuError(
                    f"parameters.{name}: it is of causality {variable.causality}; only parameters can be set"
                )
            wanted = 1 if isinstance(found, Element) else variable.size
            items = [value] if isinstance(value, (bool, int, float, str)) else list(value)
            if len(items) != wanted:
                raise FmuError(f"parameters.{name}: expected {wanted} values, got {len(items)}")
            first = found.index if isinstance(found, Element) else 0
            for i, item in enumerate(items):
                self._put(variable, first + i, _typed(variable, item, f"parameters.{name}"))

    def fill(self, name: str, value: ArrayLike, unit: str) -> bool:
        """Set the parameter `name`, an array or scalars name[i] or name[i,j], to a value in SI units.

        Returns:
            True if the FMU has such a parameter.

        Raises:
            FmuError: if its unit is of another kind of quantity.
        """
        array = np.asarray(value, dtype=np.float64)
        elements = self._elements(name, array.shape)
        if elements is None:
            return False
        for element, number in zip(elements, array.ravel().tolist(), strict=True):
            self._put(element.variable, element.index, _in_unit(element.variable, number, unit))
        return True

    def _elements(self, name: str, shape: tuple[int, ...]) -> list[Element] | None:
        """Return the real parameters of an array `name`, row by row; None if some are missing."""
        whole = self.description.by_name.get(name)
        if whole is not None and whole.size == math.prod(shape):
            return list(whole.elements) if _fillable(whole) else None
        elements = []
        for place in np.ndindex(*shape):
            each = self.description.by_name.get(f"{name}[{','.join(str(i + 1) for i in place)}]")
            if each is None or not _fillable(each) or each.size != 1:
                return None
            elements.append(each.elements[0])
        return elements

    def _put(self, variable: Variable, index: int, value: Value) -> None:
        reference = variable.value_reference
        if reference not in self._values:
            self._variables[reference] = variable
            given = variable.start or ("0",)
            starts = [_read(variable, text) for text in given]
            self._values[reference] = starts if len(starts) == variable.size else starts[:1] * variable.size
        self._values[reference][index] = value


def _fillable(variable: Variable) -> bool:
    return variable.causality == "parameter" and variable.kind in REALS


def _in_unit(variable: Variable, number: float, wanted: str) -> float:
    """Convert from SI."""
    unit = variable.unit
    if unit is not None and unit.exponents is None:
        unit = known_unit(unit.name)
    if unit is None:
        return number
    if wanted and not alike(unit, si(wanted)):
        raise FmuError(
            f"parameter '{variable.name}': expected the unit {wanted}, got {unit.name}; set from_robot: false"
        )
    return (number - unit.offset) / unit.factor


def _read(variable: Variable, text: str) -> Value:
    """Return a start value of the model description."""
    if variable.kind in FLOATS:
        return float(text)
    if variable.kind == "String":
        return text
    if variable.kind == "Boolean":
        return text in ("true", "1")
    return int(text)


def _typed(variable: Variable, value: Value, where: str) -> Value:
    """Return the value in the type of the variable.

    Raises:
        FmuError: if it has another type.
    """
    if variable.kind in FLOATS and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    expected: type = str if variable.kind == "String" else bool if variable.kind == "Boolean" else int
    if variable.kind in FLOATS or type(value) is not expected:
        raise FmuError(f"{where}: expected a value of the kind {variable.kind}, got {shown(value)}")
    if expected is int and not _fits(variable.kind, int(value)):
        raise FmuError(f"{where}: {value} is beyond what a variable of the kind {variable.kind} can hold")
    return value


def _fits(kind: str, value: int) -> bool:
    """Return whether an integer fits: one that does not would be truncated silently."""
    bits = int(re.sub(r"\D", "", kind) or (32 if kind == "Integer" else 64))
    if kind.startswith("U"):
        return 0 <= value < 1 << bits
    return -(1 << bits - 1) <= value < 1 << bits - 1
