"""Table of the parts that scenarios add to the loop. A new part is a file of its own and an entry here."""

from __future__ import annotations

from collections.abc import Callable

from cdpr.scenario import Scenario
from cdpr.simulation.loop_part import LoopPart

# Each entry returns its part for a scenario, or None if the scenario has none. Operations run in this order.
LOOP_PARTS: list[Callable[[Scenario], LoopPart | None]] = []


def loop_parts(scenario: Scenario) -> tuple[LoopPart, ...]:
    """Return new parts for the loop of a scenario, not yet connected."""
    made = (part_of(scenario) for part_of in LOOP_PARTS)
    return tuple(part for part in made if part is not None)
