"""Conversion of an FMU's values to SI, by the units of the FMU or of the scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cdpr.base.errors import FmuError
from cdpr.base.units import Unit, alike, known_unit, si
from cdpr.fmu.read.model import Element
from cdpr.fmu.read.options import Source


@dataclass(frozen=True)
class Conversion:
    """SI value = value * scale + offset, for each number; `units` are the FMU's."""

    scale: tuple[float, ...]
    offset: tuple[float, ...]
    units: tuple[str, ...]
    notices: tuple[str, ...]  # assumptions made


def convert(
    elements: Sequence[Element], wanted: Sequence[str], source: Source | None, defined: Mapping[str, Unit]
) -> Conversion:
    """Return the conversion of each element to the `wanted` SI unit, "" for any kind.

    `defined` are the units of the FMU.

    Raises:
        FmuError: if a unit is unknown or of another kind of quantity.
    """
    source = source or Source(variable="")
    if source.factor == 0.0:
        raise FmuError("the factor cannot be 0")
    of_elements = [source.unit] * len(elements) if source.unit is None or isinstance(source.unit, str) else source.unit
    if len(of_elements) != len(elements):
        raise FmuError(f"expected {len(elements)} units, got {len(of_elements)}")
    units, undeclared, undefined = [], [], []
    for element, target, name in zip(elements, wanted, of_elements, strict=True):
        declared = element.variable.unit
        if name is not None:
            unit = _named(name, defined)
        elif declared is None:
            unit = si(target or "1")
            # An array of forces and moments cannot declare a unit; dimensionless values need none.
            if target != "1" and (element.variable.size == 1 or len(set(wanted)) == 1):
                undeclared.append(target or "SI")
        elif declared.exponents is None:
            unit = _named(declared.name, defined)
            if any(unit.exponents or ()):  # "1" needs no definition
                undefined.append(declared.name)
        else:
            unit = declared
        if target and not alike(unit, si(target)):
            should = "has no unit" if target == "1" else f"is measured in {target}"
            raise FmuError(f"'{element.name}' is in {unit.name}, but this signal {should}")
        units.append(unit)
    notices = [f"the FMU declares no unit, read as {' and '.join(dict.fromkeys(undeclared))}"] if undeclared else []
    notices += [f"the FMU does not define its unit '{name}', read as that" for name in dict.fromkeys(undefined)]
    return Conversion(
        scale=tuple(unit.factor * source.factor for unit in units),
        offset=tuple(
            0.0 if element.variable.relative else unit.offset * source.factor
            for element, unit in zip(elements, units, strict=True)
        ),
        units=tuple(unit.name for unit in units),
        notices=tuple(notices),
    )


def declares(elements: Sequence[Element], wanted: Sequence[str]) -> bool:
    """Return whether each element declares a unit of the wanted kind; dimensionless values need none."""
    return all(_declares(element.variable.unit, target) for element, target in zip(elements, wanted, strict=True))


def _declares(unit: Unit | None, target: str) -> bool:
    if unit is not None and unit.exponents is None:
        unit = known_unit(unit.name)
        if unit is None:
            return False
    if unit is None:
        return target == "1"
    if target == "1":
        return not any(unit.exponents or ())
    return not target or alike(unit, si(target))


def _named(name: str, defined: Mapping[str, Unit]) -> Unit:
    unit = defined.get(name)
    if unit is None or unit.exponents is None:
        unit = known_unit(name)
    if unit is None:
        raise FmuError(f"the unit '{name}' is unknown and not defined by the FMU; set `unit:`, such as mm/s or N.m")
    return unit
