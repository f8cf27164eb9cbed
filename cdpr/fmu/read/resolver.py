"""Resolution of each signal on one side of an FMU, by the rules in `cdpr.fmu.read.mapping`."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from cdpr.base.errors import FmuError
from cdpr.base.nearest import did_you_mean, nearest
from cdpr.base.problems import short_repr
from cdpr.cables import commands_of, immediate
from cdpr.fmu.read.candidates import NUMBERED, Candidate, Finder, unique
from cdpr.fmu.read.conversion import convert, declares
from cdpr.fmu.read.model import REALS, Element, ModelDescription
from cdpr.fmu.read.options import Signals, Source
from cdpr.fmu.read.ports import Port
from cdpr.fmu.read.signals import INPUTS, OUTPUTS, UNITS_OF_COMMANDS, WINCHED, WXYZ, XYZ, Role, Signal
from cdpr.model import Robot

NONE = "none"  # value in a scenario: the FMU has no such signal
COMPARED = 2000  # names for the suggestion of a similar one; an FMU may have any number
EULER = "euler"  # replaces quaternion if a scenario gives angles


class Resolver:
    """Mapping of one side, "inputs" or "outputs"; errors go to `problems`, assumptions to `notices`."""

    def __init__(self, description: ModelDescription, robot: Robot, options: Signals, role: Role, side: str) -> None:
        self.description = description
        self.robot = robot
        self.side = side
        self.signals = (INPUTS if side == "inputs" else OUTPUTS)[role]
        if role == "plant" and side == "outputs" and not immediate(robot):
            self.signals += WINCHED
        # Units of the commands: those of the robot's winches.
        self.commands = [] if role == "winch" else [UNITS_OF_COMMANDS[each] for each in commands_of(robot)]
        self.given = options.inputs if side == "inputs" else options.outputs
        self.order = options.cable_order
        self.notices: list[str] = []
        self.problems: list[str] = []
        own = (side.removesuffix("s"),)
        self.finder = Finder(description, own)
        self.terminals = [Finder(description, own, members) for members in description.terminals]
        # A variable that the scenario names may also be a local one of the FMU.
        self.wide = self.finder if side == "inputs" else Finder(description, ("output", "local", "calculatedParameter"))

    def run(self) -> dict[str, Port]:
        """Map all signals."""
        self._check_given()
        ports: dict[str, Port] = {}
        for signal in self.signals:
            key = self._key(signal)
            try:
                port = self._signal(signal, key)
            except FmuError as error:
                self._problem(key, str(error))
            else:
                if port is not None:
                    ports[signal.name] = port
        self._check_choice(ports)
        self._check_shared(ports)
        return ports

    def _check_given(self) -> None:
        known = {signal.name for signal in self.signals}
        known |= {_euler(name) for name in known}
        for name in self.given:
            if name not in known:
                text = f"unknown signal; allowed: {', '.join(sorted(known))}; {did_you_mean(name, sorted(known))}"
                self._problem(name, text.rstrip("; "))

    def _key(self, signal: Signal) -> str:
        """Return the scenario's key of a signal."""
        return _euler(signal.name) if _euler(signal.name) in self.given else signal.name

    def _signal(self, signal: Signal, key: str) -> Port | None:
        """Return the port of one signal, None if it is optional and missing."""
        given = self.given.get(key)
        if given == NONE:
            if self._required(signal):
                raise FmuError("cannot be none: it is needed")
            return None
        if given is None:
            return self._automatic(signal)
        source = given if isinstance(given, Source) else Source(variable=given)
        if key != signal.name:
            return self._port(signal, self._explicit(source, 3), source, "given", euler=_axes(source.order))
        elements = self._explicit(source, self._count(signal), signal)
        if source.order is not None:
            if signal.components != WXYZ or source.order not in ("wxyz", "xyzw"):
                raise FmuError(f"only quaternions have an order, wxyz or xyzw, got {short_repr(source.order)}")
            if source.order == "xyzw":
                elements = [elements[3], *elements[:3]]
        return self._port(signal, elements, source, "given")

    def _explicit(self, source: Source, count: int, signal: Signal | None = None) -> list[Element]:
        """Return the elements that the scenario names."""
        name = source.variable
        if not isinstance(name, str):
            if len(name) != count:
                raise FmuError(f"expected {count} variables, got {len(name)}")
            return [self._element(each) for each in name]
        if NUMBERED.search(name):
            candidates = self.wide.pattern(name, count)
        else:
            candidates = self.wide.named(name, count, () if signal is None else signal.components)
        if not candidates:
            raise FmuError(f"no {self._kind(count)} is named '{name}'{self._near(name)}")
        if len(candidates) > 1:
            raise FmuError(f"'{name}' may mean {_listed(candidates)}; list the variables")
        return self._ordered(signal, candidates[0].elements)

    def _element(self, name: str) -> Element:
        try:
            found = self.description.find(name)
        except FmuError as error:
            raise FmuError(f"{error}{self._near(name)}") from None
        if not isinstance(found, Element):
            if found.size != 1:
                raise FmuError(
                    f"'{name}' has {found.size} elements; name one of them, such as {found.elements[0].name}"
                )
            found = found.elements[0]
        variable = found.variable
        if variable.name not in self.wide.variables:
            wrong = variable.kind if variable.kind not in REALS else variable.causality
            raise FmuError(f"'{name}' is of the kind {wrong}; expected {self._kind(1)}")
        return found

    def _automatic(self, signal: Signal) -> Port | None:
        """Search by the rules; the first match decides."""
        count, parts = self._count(signal), signal.components
        units = self._units(signal, count)
        for rule, found in (
            ("name", [*self.finder.named(signal.name, count, parts), *self._halves(signal)]),
            ("terminal", [each for terminal in self.terminals for each in terminal.named(signal.name, count, parts)]),
            (
                "usual name",
                [
                    each
                    for other in signal.synonyms
                    for each in self.finder.named(other, count, parts)
                    if declares(each.elements, units)
                ],
            ),
        ):
            candidates = unique(found)
            if len(candidates) > 1:
                raise FmuError(f"ambiguous: {_listed(candidates)}; choose one under signals.{self.side}")
            if candidates:
                return self._port(signal, self._ordered(signal, candidates[0].elements), None, rule)
        if self._required(signal):
            raise FmuError(f"needed, but there is no {self._kind(count)} of that name{self._near(signal.name)}")
        return None

    def _halves(self, signal: Signal) -> list[Candidate]:
        """Return a force and a moment by their names."""
        found = [self.finder.named(name, 3, XYZ) for name in signal.halves]
        pairs = itertools.product(*found) if found else ()
        return [Candidate(tuple(each for half in pair for each in half.elements)) for pair in pairs]

    def _port(
        self, signal: Signal, elements: Sequence[Element], source: Source | None, rule: str, euler: str = ""
    ) -> Port:
        wanted = ("rad",) * 3 if euler else self._units(signal, len(elements))
        conversion = convert(elements, wanted, source, self.description.units)
        self.notices += [f"{self.side} {signal.name}: {notice}" for notice in conversion.notices]
        return Port(signal.name, elements, conversion, euler=euler, rule=rule, source=source)

    def _ordered(self, signal: Signal | None, elements: Sequence[Element]) -> list[Element]:
        """Sort the FMU's cables in the robot's order."""
        if signal is None or signal.size or self.order is None:
            return list(elements)
        return [elements[number - 1] for number in self.order]

    def _count(self, signal: Signal) -> int:
        return signal.size or self.robot.m

    def _units(self, signal: Signal, count: int) -> Sequence[str]:
        """Return the SI unit of each number."""
        return self.commands if signal.name == "command" and self.commands else signal.units(count)

    def _required(self, signal: Signal) -> bool:
        turning = any(name.startswith("r") for name in self.robot.dof)
        return signal.need == "required" and (turning or signal.name not in ("quaternion", "angular_velocity"))

    def _check_choice(self, ports: dict[str, Port]) -> None:
        choices = [signal for signal in self.signals if signal.need == "choice"]
        found = [signal.name for signal in choices if signal.name in ports]
        wrong = any(self.given.get(signal.name, NONE) != NONE for signal in choices)  # already reported
        if len(found) > 1:
            self.problems.append(
                f"signals.{self.side}: the FMU has both {' and '.join(found)}; set one of them to `none`"
            )
        elif choices and not found and not wrong:
            kinds = " or ".join(f"{signal.name} ({self._count(signal)} numbers)" for signal in choices)
            self.problems.append(f"signals.{self.side}: {kinds} is needed{self._near(choices[0].name)}")

    def _check_shared(self, ports: dict[str, Port]) -> None:
        """Reject one number of the FMU for two signals."""
        owner: dict[tuple[int, int], str] = {}
        for name, port in ports.items():
            for element in port.elements:
                place = (element.variable.value_reference, element.index)
                if place in owner:
                    self._problem(name, f"'{element.name}' is already used for {owner[place]}")
                    break
                owner[place] = name

    def _kind(self, count: int) -> str:
        what = self.side.removesuffix("s")
        return f"{what} with {count} numbers" if count > 1 else f"real {what}"

    def _near(self, name: str) -> str:
        """Return the variables with the most similar names, or the first few."""
        sizes = {variable.name: variable.size for variable in self.finder.variables.values()}
        near = nearest(name, list(sizes)[:COMPARED], 4, 0.5) or list(sizes)[:8]
        shown = ", ".join(each + (f" ({sizes[each]} numbers)" if sizes[each] > 1 else "") for each in near)
        return f"; {self.side} of the FMU: {shown}" if near else f"; the FMU has no real {self.side}"

    def _problem(self, key: str, text: str) -> None:
        self.problems.append(f"signals.{self.side}.{key}: {text}")


def _euler(name: str) -> str:
    return name.replace("quaternion", EULER)


def _axes(order: str | None) -> str:
    """Check an order of Euler angles."""
    axes = (order or "").lower()
    sound = len(axes) == 3 and set(axes) <= set(XYZ) and axes[0] != axes[1] != axes[2]
    if order is None or not sound or order not in (axes, axes.upper()):
        raise FmuError(
            f"needs `order`, the axes as in scipy: upper case moving (XYZ), lower case fixed; got {short_repr(order)}"
        )
    return order


def _listed(candidates: Sequence[Candidate]) -> str:
    return " or ".join(candidate.name for candidate in candidates)
