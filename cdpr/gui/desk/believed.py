"""What is believed of cables: the i-th of the form is that of the robot, the file names those that differ."""

from __future__ import annotations

from typing import Any

from cdpr.problems import Path
from cdpr.scenario.belief import cable_names


def entries(said: Any, cables: list[Any]) -> dict[int, int]:
    """Return which item of the list `said` speaks of which cable of the robot: items by cables, counted from 0."""
    if not isinstance(said, list):
        return {}
    names = cable_names(cables)
    found: dict[int, int] = {}
    for item, entry in enumerate(said):
        name = entry.get("name") if isinstance(entry, dict) else None
        if name is None and len(said) == len(cables):
            name = names[item]
        if name in names:
            found.setdefault(names.index(name), item)
    return found


def cables_in_place(said: Any, cables: list[Any]) -> list[Any]:
    """Return for each cable of the robot what is believed of it, but for its name; what is no mapping as it is."""
    found = entries(said, cables)
    rows: list[Any] = []
    for i in range(len(cables)):
        entry = said[found[i]] if i in found else {}
        named = isinstance(entry, dict)
        rows.append({key: value for key, value in entry.items() if key != "name"} if named else entry)
    return rows


def target(path: Path, said: Any, cables: Any) -> tuple[Path, dict[str, Any] | None]:
    """Return where the file holds what the form calls `path`, below `believed`; and the entry that is to be made first.

    A cable of which nothing is said yet gets an entry of its own at the end.
    """
    if len(path) < 2 or path[0] != "cables" or not isinstance(path[1], int) or not isinstance(cables, list):
        return path, None
    found = entries(said, cables)
    if path[1] in found:
        return ("cables", found[path[1]], *path[2:]), None
    names = cable_names(cables)
    if path[1] >= len(names):
        return path, None
    count = len(said) if isinstance(said, list) else 0
    return ("cables", count, *path[2:]), {"name": names[path[1]]}
