"""Exchange between the signals of cdpr and the numbers of an FMU: positions, units, order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.fmu.read.conversion import Conversion
from cdpr.fmu.read.model import Element, Variable
from cdpr.fmu.read.options import Source
from cdpr.model import rotations
from cdpr.model.robot import Array


class Port:
    """One signal: k numbers of the FMU, in the order of the signal.

    Attributes:
        index: (k,) positions among all values of their side, see `Side`.
        scale, offset: (k,) the signal in SI = value * scale + offset.
        euler: order of axes if the values are angles (k = 3) for a quaternion (4 numbers), otherwise empty.
        rule: rule of the mapping.
        source: option of the scenario.
    """

    def __init__(
        self,
        signal: str,
        elements: Sequence[Element],
        conversion: Conversion,
        *,
        euler: str,
        rule: str,
        source: Source | None,
    ) -> None:
        self.signal = signal
        self.elements = tuple(elements)
        self.scale = np.array(conversion.scale)
        self.offset = np.array(conversion.offset)
        self.units = conversion.units
        self.euler = euler
        self.rule = rule
        self.source = source
        self.index: NDArray[np.intp] = np.zeros(len(elements), dtype=np.intp)
        self._angles = np.zeros(len(elements))

    def read(self, values: Array, out: Array) -> None:
        """Write the signal, SI, into `out`; `values` are all values of the FMU's outputs."""
        raw = self._angles if self.euler else out
        np.take(values, self.index, out=raw, mode="clip")
        np.multiply(raw, self.scale, out=raw)
        np.add(raw, self.offset, out=raw)
        if self.euler:
            out[:] = rotations.from_euler(raw, self.euler)

    def write(self, signal: Array, values: Array) -> None:
        """Write the signal, SI, into `values`, those of all the FMU's inputs."""
        np.subtract(rotations.to_euler(signal, self.euler) if self.euler else signal, self.offset, out=self._angles)
        np.divide(self._angles, self.scale, out=self._angles)
        values[self.index] = self._angles

    def describe(self) -> dict[str, Any]:
        """Return plain data for the metadata of a run."""
        return {
            "signal": self.signal,
            "variables": [element.name for element in self.elements],
            "units": list(self.units),
            "scale": self.scale.tolist(),
            "offset": self.offset.tolist(),
            **({"euler": self.euler} if self.euler else {}),
            "rule": self.rule,
        }


@dataclass(frozen=True, eq=False)
class Side:
    """All mapped inputs or all mapped outputs: whole variables with their elements side by side."""

    variables: tuple[Variable, ...]  # each value reference once, ascending
    ports: dict[str, Port]  # by signal

    @staticmethod
    def of(ports: dict[str, Port]) -> Side:
        """Lay out the variables of the ports, and set the positions of each port."""
        by_reference = {e.variable.value_reference: e.variable for port in ports.values() for e in port.elements}
        variables = tuple(by_reference[reference] for reference in sorted(by_reference))
        starts, place = {}, 0
        for variable in variables:
            starts[variable.value_reference] = place
            place += variable.size
        for port in ports.values():
            port.index[:] = [starts[e.variable.value_reference] + e.index for e in port.elements]
        return Side(variables, ports)

    @property
    def value_references(self) -> tuple[int, ...]:
        """Return the value references of the variables."""
        return tuple(variable.value_reference for variable in self.variables)

    @cached_property
    def size(self) -> int:
        """Return the number of values."""
        return sum(variable.size for variable in self.variables)

    def start(self) -> Array:
        """Return the FMU's start values (size,), zero for omitted ones."""
        values = np.zeros(self.size)
        place = 0
        for variable in self.variables:
            if variable.start is not None:
                values[place : place + variable.size] = [float(text) for text in variable.start]
            place += variable.size
        return values
