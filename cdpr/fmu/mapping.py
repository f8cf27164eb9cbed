"""Ties the variables of an FMU to the signals of cdpr, by the scenario's word or by rules that are certain.

The rules for a signal that the scenario does not name, the first that finds anything decides, and finding two things
is an error: an array or a family called exactly like the signal, by name or alias; then one called by another usual
name, if length and unit agree. The order of declaration never counts.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping as MappingType
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cdpr.errors import FmuError
from cdpr.fmu.candidates import NUMBERED, Candidate, Finder, elements_of
from cdpr.fmu.model import REALS, Element, ModelDescription, Unit
from cdpr.fmu.options import Signals, Source, Variables
from cdpr.fmu.ports import Port, Side
from cdpr.fmu.signals import INPUTS, OUTPUTS, WXYZ, XYZ, Role, Signal
from cdpr.fmu.units import alike, known_unit, si
from cdpr.model import Robot

NONE = "none"  # said in a scenario: the FMU has no such signal
EULER = "euler"  # stands for quaternion where a scenario gives angles


@dataclass(frozen=True, eq=False)
class Mapping:
    """The signals of an FMU for one robot, inputs and outputs by signal."""

    role: Role
    inputs: Side
    outputs: Side
    notices: tuple[str, ...]  # what was assumed

    def describe(self) -> dict[str, Any]:
        """Return plain data for the record of a run."""
        return {
            "role": self.role,
            "inputs": [port.describe() for port in self.inputs.ports.values()],
            "outputs": [port.describe() for port in self.outputs.ports.values()],
            "notices": list(self.notices),
        }


def map_signals(
    description: ModelDescription, robot: Robot, options: Signals | None = None, role: Role = "plant"
) -> Mapping:
    """Return the mapping; FmuError with all that is wrong, one line each."""
    mapping, problems = resolve(description, robot, options or Signals(), role)
    if problems:
        raise FmuError("\n".join(problems))
    return mapping


def resolve(
    description: ModelDescription, robot: Robot, options: Signals, role: Role
) -> tuple[Mapping, tuple[str, ...]]:
    """Return what can be mapped, and what is wrong with the rest."""
    notices: list[str] = []
    inputs = _Resolver(description, robot, options, role, "inputs", notices)
    outputs = _Resolver(description, robot, options, role, "outputs", notices)
    sides = [Side.of(inputs.run()), Side.of(outputs.run())]
    mapped = {variable.name for variable in sides[0].variables}
    idle = [each.name for each in description.variables if each.causality == "input" and each.name not in mapped]
    if idle:
        shown = ", ".join(idle[:8]) + (f" and {len(idle) - 8} more" if len(idle) > 8 else "")
        notices.append(f"inputs that keep their start value: {shown}")
    return Mapping(role, sides[0], sides[1], tuple(notices)), (*inputs.problems, *outputs.problems)


class _Resolver:
    """Maps one side; whatever is wrong goes to `problems`."""

    def __init__(
        self,
        description: ModelDescription,
        robot: Robot,
        options: Signals,
        role: Role,
        side: str,
        notices: list[str],
    ) -> None:
        self.description = description
        self.robot = robot
        self.side = side
        self.signals = (INPUTS if side == "inputs" else OUTPUTS)[role]
        self.given: MappingType[str, Variables | Source] = options.inputs if side == "inputs" else options.outputs
        self.order = options.cable_order
        self.notices = notices
        self.problems: list[str] = []
        direction = side.removesuffix("s")
        self.finder = Finder(description, (direction,))
        # A variable that the scenario names may also be one that the FMU does not call an output.
        self.wide = self.finder if side == "inputs" else Finder(description, ("output", "local", "calculatedParameter"))

    def run(self) -> dict[str, Port]:
        """Map all signals."""
        self._check_given()
        ports: dict[str, Port] = {}
        for signal in self.signals:
            port = self._signal(signal)
            if port is not None:
                ports[signal.name] = port
        self._check_choice(ports)
        self._check_shared(ports)
        return ports

    def _check_given(self) -> None:
        known = {signal.name for signal in self.signals}
        known |= {name.replace("quaternion", EULER) for name in known}
        for name in self.given:
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                hint = f"; did you mean '{near[0]}'?" if near else ""
                self._problem(name, f"is no signal here; known are {', '.join(sorted(known))}{hint}")
        if self.order is not None and sorted(self.order) != list(range(1, self.robot.m + 1)) and self.side == "inputs":
            self.problems.append(f"signals.cable_order: each of 1 to {self.robot.m} once is expected")

    def _signal(self, signal: Signal) -> Port | None:
        euler = signal.name.replace("quaternion", EULER)
        key = euler if euler in self.given else signal.name
        given = self.given.get(key)
        count = signal.size or self.robot.m
        if given == NONE:
            if self._required(signal):
                self._problem(key, "cannot be none: cdpr needs it")
            return None
        if given is None:
            return self._automatic(signal, count)
        source = given if isinstance(given, Source) else Source(variable=given)
        if key == euler != signal.name:
            return self._euler(signal, key, source)
        elements = self._explicit(key, source, count, signal)
        if elements is None:
            return None
        if source.order is not None:
            if signal.components != WXYZ or source.order not in ("wxyz", "xyzw"):
                self._problem(key, f"the order {source.order!r} is not known; only quaternions have one: wxyz, xyzw")
                return None
            if source.order == "xyzw":
                elements = [elements[3], *elements[:3]]
        return self._port(signal, key, elements, signal.units(count), source, "given")

    def _euler(self, signal: Signal, key: str, source: Source) -> Port | None:
        order = source.order or ""
        axes = order.lower()
        proper = len(order) == 3 and set(axes) <= set(XYZ) and order in (axes, order.upper())
        if not proper or axes[0] == axes[1] or axes[1] == axes[2]:
            self._problem(
                key, f"needs its order of axes, as in scipy: upper case moving (XYZ), lower case fixed; got {order!r}"
            )
            return None
        elements = self._explicit(key, source, 3, signal)
        return None if elements is None else self._port(signal, key, elements, ("rad",) * 3, source, "given", order)

    def _explicit(self, key: str, source: Source, count: int, signal: Signal) -> list[Element] | None:
        """Return the elements that the scenario names."""
        name = source.variable
        if not isinstance(name, str):
            if len(name) != count:
                self._problem(key, f"{count} variables are expected, got {len(name)}")
                return None
            found = [self._element(key, each) for each in name]
            elements = [each for each in found if each is not None]
            return elements if len(elements) == count else None
        if NUMBERED.search(name):
            candidates = self.wide.pattern(name, count)
        else:
            candidates = self.wide.named(name, count, () if key != signal.name else signal.components)
        if len(candidates) == 1:
            return self._ordered(signal, candidates[0].elements)
        if candidates:
            self._problem(key, f"'{name}' may mean {_listed(candidates)}; list the variables")
        else:
            self._problem(key, f"'{name}' is no {self._kind(count)}{self._near(name)}")
        return None

    def _element(self, key: str, name: str) -> Element | None:
        try:
            found = self.description.find(name)
        except FmuError as error:
            self._problem(key, f"{error}{self._near(name)}")
            return None
        element = found if isinstance(found, Element) else elements_of(found, name)[0]
        variable = element.variable
        if not isinstance(found, Element) and found.size != 1:
            self._problem(key, f"'{name}' has {found.size} elements; name one of them, such as {name}[1]")
        elif variable.name not in {each.name for each in self.wide.variables.values()}:
            wrong = variable.kind if variable.kind not in REALS else variable.causality
            self._problem(key, f"'{name}' is of the kind {wrong}; {self._kind(1)} is expected")
        else:
            return element
        return None

    def _automatic(self, signal: Signal, count: int) -> Port | None:
        candidates = self.finder.named(signal.name, count, signal.components)
        rule = "name"
        if not candidates:
            rule = "usual name"
            candidates = [
                candidate
                for other in signal.synonyms
                for candidate in self.finder.named(other, count, signal.components)
                if self._fits(candidate, signal.units(count))
            ]
        if len(candidates) > 1:
            self._problem(signal.name, f"may be {_listed(candidates)}; say which under signals.{self.side}")
            return None
        if not candidates:
            if self._required(signal):
                self._problem(signal.name, f"no {self._kind(count)} of that name{self._near(signal.name)}")
            return None
        elements = self._ordered(signal, candidates[0].elements)
        return self._port(signal, signal.name, elements, signal.units(count), None, rule)

    def _fits(self, candidate: Candidate, units: Sequence[str]) -> bool:
        """Tell whether the declared units are those of the signal; without one only what has no unit fits."""
        for element, wanted in zip(candidate.elements, units, strict=True):
            unit = element.variable.unit
            if unit is None:
                if wanted != "1":
                    return False
            elif unit.exponents is None or (wanted and not alike(unit, si(wanted))):
                return False
        return True

    def _ordered(self, signal: Signal, elements: Sequence[Element]) -> list[Element]:
        if signal.size or self.order is None or sorted(self.order) != list(range(1, len(elements) + 1)):
            return list(elements)
        return [elements[number - 1] for number in self.order]

    def _port(
        self,
        signal: Signal,
        key: str,
        elements: Sequence[Element],
        wanted: Sequence[str],
        source: Source | None,
        rule: str,
        euler: str = "",
    ) -> Port | None:
        scales, offsets, names = [], [], []
        said = None if source is None else source.unit
        if said is not None and not isinstance(said, str) and len(said) != len(elements):
            self._problem(key, f"{len(elements)} units are expected, got {len(said)}")
            return None
        factor = 1.0 if source is None else source.factor
        if factor == 0.0:
            self._problem(key, "the factor cannot be 0")
            return None
        for i, (element, si_name) in enumerate(zip(elements, wanted, strict=True)):
            unit = self._unit(key, element, si_name, said if said is None or isinstance(said, str) else said[i])
            if unit is None:
                return None
            scales.append(unit.factor * factor)
            offsets.append(0.0 if element.variable.relative else unit.offset * factor)
            names.append(unit.name)
        return Port(signal.name, elements, scales, offsets, euler=euler, rule=rule, units=names)

    def _unit(self, key: str, element: Element, wanted: str, said: str | None) -> Unit | None:
        """Return the unit of one element, checked; what had to be assumed becomes a notice."""
        name, unit = element.variable.name, element.variable.unit
        if said is not None:
            defined = self.description.units.get(said)
            unit = defined if defined is not None and defined.exponents is not None else known_unit(said)
            if unit is None:
                self._problem(key, f"the unit '{said}' is not known; write it like mm/s, N.m or deg")
                return None
        elif unit is None:
            if wanted != "1":
                self._notice(f"{name}: the FMU declares no unit; read as {wanted or 'SI'}")
            return si(wanted or "1")
        elif unit.exponents is None:
            known = known_unit(unit.name)
            if known is None:
                self._problem(key, f"'{name}' has the unit '{unit.name}', which the FMU does not define; say `unit:`")
                return None
            self._notice(f"{name}: the FMU does not define its unit '{unit.name}'; read as that")
            unit = known
        if wanted and not alike(unit, si(wanted)):
            self._problem(key, f"'{element.name}' is in {unit.name}, which is not a unit of this signal ({wanted})")
            return None
        return unit

    def _required(self, signal: Signal) -> bool:
        turning = any(name.startswith("r") for name in self.robot.dof)
        return signal.need == "required" and (turning or signal.name not in ("quaternion", "angular_velocity"))

    def _check_choice(self, ports: dict[str, Port]) -> None:
        names = [signal.name for signal in self.signals if signal.need == "choice"]
        found = [name for name in names if name in ports]
        if len(found) > 1:
            self.problems.append(
                f"signals.{self.side}: the FMU has both {' and '.join(found)}; say `none` for one of them"
            )
        elif names and not found and not any(name in self.given and self.given[name] != NONE for name in names):
            kinds = " or ".join(f"{name} ({self._size(name)})" for name in names)
            self.problems.append(f"signals.{self.side}: the FMU has none of {kinds}{self._near(names[0])}")

    def _check_shared(self, ports: dict[str, Port]) -> None:
        """Refuse that one number is two: of two signals, or twice in one."""
        owner: dict[tuple[int, int], str] = {}
        for name, port in ports.items():
            for element in port.elements:
                place = (element.variable.value_reference, element.index)
                if place in owner:
                    self._problem(name, f"'{element.name}' is also taken for {owner[place]}")
                    break
                owner[place] = name

    def _size(self, name: str) -> int:
        return next(signal.size for signal in self.signals if signal.name == name) or self.robot.m

    def _kind(self, count: int) -> str:
        what = self.side.removesuffix("s")
        return f"{what} with {count} numbers" if count > 1 else f"real {what}"

    def _near(self, name: str) -> str:
        """List the variables whose names are closest."""
        names = {variable.name for variable in self.finder.variables.values()}
        near = difflib.get_close_matches(name, names, 4, 0.5) or sorted(names)[:8]
        what = self.side
        return f"; {what} of the FMU like it: {', '.join(near)}" if near else f"; the FMU has no real {what}"

    def _problem(self, key: str, text: str) -> None:
        self.problems.append(f"signals.{self.side}.{key}: {text}")

    def _notice(self, text: str) -> None:
        if text not in self.notices:
            self.notices.append(text)


def _listed(candidates: Sequence[Candidate]) -> str:
    return " or ".join(candidate.name for candidate in candidates)
