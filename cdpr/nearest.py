"""Which name was meant: the one place that compares names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

COMPARED = 60  # characters of a foreign name; more would take long
BEGINNING = 3  # letters of a name that is cut off; fewer begin too many
ALIKE = 0.6  # least share of what two names have in common


def nearest(name: str, names: Iterable[str], count: int = 1, alike: float = ALIKE) -> list[str]:
    """Return the names that are closest to `name`, the closest first: `count` at most, or none.

    Capitals make no difference, and a beginning counts as its name.
    """
    given, known = name[:COMPARED], list(names)
    found = difflib.get_close_matches(given, known, count, alike)
    small = given.casefold()
    for each in known:
        if each not in found and (each.casefold() == small or (len(small) >= BEGINNING and each.startswith(small))):
            found.append(each)
    return found[:count]


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Return "did you mean 'x'? " or nothing."""
    return "".join(f"did you mean '{near}'? " for near in nearest(name, names))
