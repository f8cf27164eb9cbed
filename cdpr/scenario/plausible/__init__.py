"""What is allowed and seldom meant: a table of checks, each a small function that yields path and text.

They are asked of what passed all checks of the loader, and only when somebody wants to know (`Scenario.warnings`), so
that studies and live sessions pay nothing. A check looks at no file and changes nothing. To add one, write the function
and name it here. A check that is wrong once in a while is worse than none: each of their bounds is wide, says why, and
holds for robots from a hand's size to that of a valley (tests/unit/test_plausible.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cdpr.problems import Path, Problem
from cdpr.scenario.document import Document
from cdpr.scenario.plausible.angles import whole_turns
from cdpr.scenario.plausible.course import after_the_end, cut_short, gravity, of_the_motion, taken_by_the_guide
from cdpr.scenario.plausible.interference import touching
from cdpr.scenario.plausible.passing import through_singular_places
from cdpr.scenario.plausible.places import beyond_reach, far, no_length, one_sided, outside, too_weak
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.plausible.sizes import bodies, cable_sizes, dents, proportions

__all__ = ["CHECKS", "Finding", "Setup", "of_places", "warnings"]

CHECKS: tuple[Callable[[Setup], Iterator[Finding]], ...] = (
    whole_turns,
    proportions,
    bodies,
    dents,
    cable_sizes,
    far,  # before those that also hold of it and do not name the unit
    no_length,
    one_sided,
    outside,
    beyond_reach,
    too_weak,
    touching,
    gravity,
    after_the_end,
    of_the_motion,
    through_singular_places,
    cut_short,
    taken_by_the_guide,
)


def of_places(setup: Setup) -> Iterator[Finding]:
    """Yield what is found of the places where it wants to go alone."""
    yield from far(setup)
    yield from outside(setup)
    yield from beyond_reach(setup)


def warnings(setup: Setup, document: Document) -> tuple[Problem, ...]:
    """Return what the checks find, each with the place where it stands in the document; of one value the first."""
    found: dict[Path, str] = {}
    for check in CHECKS:
        for path, text in check(setup):
            if not any(path[: len(part)] == part for part in document.filled):  # is told where it comes from
                found.setdefault(path, text)
    return tuple(Problem(document.mark(path), path, text) for path, text in found.items())
