"""Suggestions for misspelled names."""

from __future__ import annotations

from collections.abc import Iterable

COMPARED = 60  # characters of a foreign name; more would be slow
BEGINNING = 3  # minimum length of an abbreviation
ALIKE = 0.6  # minimum similarity of two names
SYNONYMS = {"orientation": "attitude", "attitude": "orientation"}  # keys of sensors, and of other sections


def nearest(name: str, names: Iterable[str], count: int = 1, alike: float = ALIKE) -> list[str]:
    """Return the names closest to `name`, the closest first, at most `count`.

    Case is ignored, and a beginning of a name matches it.
    """
    import difflib  # only for the message of an error

    given, known = name[:COMPARED], list(names)
    found = difflib.get_close_matches(given, known, count, alike)
    small = given.casefold()
    for each in known:
        if each not in found and (each.casefold() == small or (len(small) >= BEGINNING and each.startswith(small))):
            found.append(each)
    return found[:count]


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Return "did you mean 'x'? " or "", for a synonym or for the closest name."""
    known = list(names)
    synonym = SYNONYMS.get(str(name).casefold())
    return "".join(f"did you mean '{near}'? " for near in ([synonym] if synonym in known else nearest(name, known)))
