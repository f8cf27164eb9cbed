"""Mapping of an FMU's variables to the signals of cdpr, by the scenario or by unambiguous rules.

For a signal that the scenario does not name, the first rule with a match decides; two matches are an error:

1. an array or a family with exactly the name or alias of the signal (for a wrench also of its force and its moment); 2.
a member of a terminal with such a name; 3. another usual name, if length and unit agree.

The order of declaration never matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cdpr.base.errors import FmuError
from cdpr.base.problems import MAX_PROBLEMS, first_ones
from cdpr.fmu.read.model import ModelDescription
from cdpr.fmu.read.options import Signals
from cdpr.fmu.read.ports import Side
from cdpr.fmu.read.resolver import NONE, Resolver
from cdpr.fmu.read.signals import INPUTS, Role
from cdpr.model import Robot


@dataclass(frozen=True, eq=False)
class Mapping:
    """Signals of an FMU for one robot: inputs and outputs by signal."""

    role: Role
    inputs: Side
    outputs: Side
    notices: tuple[str, ...]  # assumptions made

    def describe(self) -> dict[str, Any]:
        """Return plain data for the metadata of a run."""
        return {
            "role": self.role,
            "inputs": [port.describe() for port in self.inputs.ports.values()],
            "outputs": [port.describe() for port in self.outputs.ports.values()],
            "notices": list(self.notices),
        }


def map_signals(
    description: ModelDescription, robot: Robot, options: Signals | None = None, role: Role = "plant"
) -> Mapping:
    """Return the mapping.

    Raises:
        FmuError: with all errors, one per line.
    """
    mapping, problems = resolve(description, robot, options, role)
    if problems:
        raise FmuError("\n".join(first_ones(problems, MAX_PROBLEMS)))
    return mapping


def resolve(
    description: ModelDescription, robot: Robot, options: Signals | None, role: Role
) -> tuple[Mapping, tuple[str, ...]]:
    """Return the possible mapping, and the errors of the rest."""
    options = options or Signals()
    order = options.cable_order
    if order is not None and sorted(order) != list(range(1, robot.m + 1)):
        problem = f"signals.cable_order: expected the numbers from 1 to {robot.m}, each once, got {list(order)}"
        return Mapping(role, Side((), {}), Side((), {}), ()), (problem,)
    inputs = Resolver(description, robot, options, role, "inputs")
    outputs = Resolver(description, robot, options, role, "outputs")
    sides = [Side.of(inputs.run()), Side.of(outputs.run())]
    notices = [*inputs.notices, *outputs.notices]
    taken = set(sides[0].value_references)
    left = [name for name, given in options.inputs.items() if given == NONE]  # deliberately not mapped
    known = (*left, *(half for signal in INPUTS[role] if signal.name in left for half in signal.halves))
    idle = [
        variable.name
        for variable in description.variables
        if variable.causality == "input" and variable.value_reference not in taken
        if not variable.name.startswith(known)
    ]
    if idle:
        shown = ", ".join(idle[:8]) + (f" and {len(idle) - 8} more" if len(idle) > 8 else "")
        notices.append(f"inputs without a signal, which keep their start value: {shown}")
    if role == "controller" and all(name.startswith("desired_") for name in sides[0].ports):
        notices.append("the FMU receives no part of the state: an open-loop controller, or one that contains a plant")
    return Mapping(role, sides[0], sides[1], tuple(notices)), (*inputs.problems, *outputs.problems)
