"""Checks for values that are allowed but probably not intended: functions that yield path and text.

They run on valid input and only on demand (`Scenario.warnings`), so that studies and live sessions have no cost. A
check reads no file and changes nothing. To add one, write the function and list it here. False warnings are worse than
none: the bounds of each check are wide and justified, and hold for robots from hand size to valley size
(tests/scenario/test_plausible.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cdpr.base.problems import Path, Problem
from cdpr.config.document import Document
from cdpr.scenario.plausible.angles import whole_turns
from cdpr.scenario.plausible.course import (
    after_the_end,
    bodies_that_do_not_turn,
    cut_short,
    gravity,
    late_sensors,
    of_the_motion,
    taken_by_the_guide,
)
from cdpr.scenario.plausible.drums import empty_drums, large_steps
from cdpr.scenario.plausible.interference import touching
from cdpr.scenario.plausible.loose import too_heavy
from cdpr.scenario.plausible.passing import through_singular_places
from cdpr.scenario.plausible.places import beyond_reach, far, no_length, one_sided, outside, too_weak
from cdpr.scenario.plausible.seen import stretched_lengths, unseen_sensors
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.plausible.sizes import bodies, cable_sizes, dents, proportions

__all__ = ["CHECKS", "Finding", "Setup", "of_places", "warnings"]

CHECKS: tuple[Callable[[Setup], Iterator[Finding]], ...] = (
    whole_turns,
    proportions,
    bodies,
    dents,
    cable_sizes,
    far,  # before checks that also apply but do not mention the unit
    no_length,
    one_sided,
    outside,
    beyond_reach,
    too_weak,
    too_heavy,
    touching,
    gravity,
    after_the_end,
    late_sensors,
    of_the_motion,
    through_singular_places,
    empty_drums,
    large_steps,
    cut_short,
    taken_by_the_guide,
    bodies_that_do_not_turn,
    unseen_sensors,
    stretched_lengths,
)


def of_places(setup: Setup) -> Iterator[Finding]:
    """Yield the findings on target positions only."""
    yield from far(setup)
    yield from outside(setup)
    yield from beyond_reach(setup)


def warnings(setup: Setup, document: Document) -> tuple[Problem, ...]:
    """Return the findings with their positions in the document; only the first one per value."""
    found: dict[Path, str] = {}
    for check in CHECKS:
        for path, text in check(setup):
            if not any(path[: len(part)] == part for part in document.filled):  # reported at its origin
                found.setdefault(path, text)
    return tuple(Problem(document.mark(path), path, text) for path, text in found.items())
