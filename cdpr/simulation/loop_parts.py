"""Table of the parts that scenarios add to the loop. A new part is a file of its own and an entry here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import get_args

from cdpr.base.errors import CdprError
from cdpr.plugins.info import Role
from cdpr.scenario import Scenario
from cdpr.simulation.drives import drives_of
from cdpr.simulation.estimation import estimation_of
from cdpr.simulation.loop_part import LoopPart
from cdpr.simulation.sensors import sensors_of

# Each entry returns its part for a scenario, or None if the scenario has none. Operations run in this order.
LOOP_PARTS: list[Callable[[Scenario], LoopPart | None]] = [drives_of, sensors_of, estimation_of]


def loop_parts(scenario: Scenario) -> tuple[LoopPart, ...]:
    """Return new parts for the loop of a scenario, not yet connected.

    Raises:
        CdprError: if two parts or two of their streams have the same name.
    """
    parts = tuple(part for part_of in LOOP_PARTS if (part := part_of(scenario)) is not None)
    streams = [stream.name for part in parts for stream in part.streams]
    for what, names in ("parts", [*get_args(Role), *(part.name for part in parts)]), ("random streams", streams):
        name, count = max(Counter(names).items(), key=lambda item: item[1], default=("", 0))
        if count > 1:
            raise CdprError(f"the loop has {count} {what} named {name!r}: expected unique names")
    return parts


def entries() -> tuple[str, ...]:
    """Return the names of the functions in `LOOP_PARTS`, with their modules."""
    return tuple(map(_name, LOOP_PARTS))


def _name(entry: Callable[..., object]) -> str:
    """Return the name of a function, of that of a partial, or of an object's class: equal in all processes."""
    while isinstance(entry, partial):
        entry = entry.func
    named = entry if hasattr(entry, "__qualname__") else type(entry)
    return f"{named.__module__}.{named.__qualname__}"


def check_entries(expected: tuple[str, ...]) -> None:
    """Raise CdprError unless this process has the same `LOOP_PARTS` as the one that sends its cases."""
    if (here := entries()) != expected:
        names, own = (", ".join(each) or "none" for each in (expected, here))
        raise CdprError(
            f"parts of the loop: expected {names}, as in the process that sends the cases, got {own} in its worker: "
            "add them to LOOP_PARTS in a file for --plugin or in an installed plugin, which workers load, too"
        )
