"""Mapping between cables of the form and entries of `believed.cables` in the file.

The form lists all cables of the robot; the file contains only those with differences, by name.
"""

from __future__ import annotations

from typing import Any

from cdpr.base.problems import Path
from cdpr.scenario.nominal import cable_names


def entries(given: Any, cables: list[Any]) -> dict[int, int]:
    """Return the item of the list `given` for each cable of the robot, by cable index starting at 0."""
    if not isinstance(given, list):
        return {}
    names = cable_names(cables)
    found: dict[int, int] = {}
    for item, entry in enumerate(given):
        name = entry.get("name") if isinstance(entry, dict) else None
        if name is None and len(given) == len(cables):
            name = names[item]
        if name in names:
            found.setdefault(names.index(name), item)
    return found


def cables_in_place(given: Any, cables: list[Any]) -> list[Any]:
    """Return the nominal values of each cable of the robot, without names; entries that are no mappings stay."""
    found = entries(given, cables)
    rows: list[Any] = []
    for i in range(len(cables)):
        entry = given[found[i]] if i in found else {}
        named = isinstance(entry, dict)
        rows.append({key: value for key, value in entry.items() if key != "name"} if named else entry)
    return rows


def target(path: Path, given: Any, cables: Any) -> tuple[Path, dict[str, Any] | None]:
    """Return the path in the file of a form path below `believed`, and the entry to create first, if any.

    A cable without an entry gets a new one at the end of the list.
    """
    if len(path) < 2 or path[0] != "cables" or not isinstance(path[1], int) or not isinstance(cables, list):
        return path, None
    found = entries(given, cables)
    if path[1] in found:
        return ("cables", found[path[1]], *path[2:]), None
    names = cable_names(cables)
    if path[1] >= len(names):
        return path, None
    count = len(given) if isinstance(given, list) else 0
    return ("cables", count, *path[2:]), {"name": names[path[1]]}
