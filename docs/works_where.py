"""Write the table and the list of docs/works_where.md. Run: python docs/works_where.py. A test compares the page."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from marked import rewritten, table

from cdpr.base.needs import USES, Needs
from cdpr.scenario.needs import declarations, part_declarations
from cdpr.scenario.schema import ScenarioSection

PAGE = Path(__file__).parent / "works_where.md"
TITLES = {
    "plant_fmu": "FMU",
    "controller_fmu": "FMU with controller",
    "bare_controller_fmu": "FMU of controller",
    "native": "real time",
    "ros2": "ROS 2",
    "rollout": "rollouts",
    "threads": "threads",
    "live": "live",
    "compare": "compare",
}


def needs_table() -> str:
    """Return the table of keys that some use rejects or leaves out: their support by each use, with reasons."""
    titles = ("key", *map(_title, USES), "remarks")
    return table(titles, (_cells(keys, needs) for keys, needs in _groups() if not _everywhere(needs)))


def everywhere_list() -> str:
    """Return the list of all other keys."""
    sections: dict[str, list[str]] = {}
    for keys, needs in _groups():
        if _everywhere(needs):
            sections.setdefault(_parent(keys[0]), []).extend(keys)
    return "\n".join(f"- {_names(keys)}" for keys in sections.values())


def _groups() -> Iterator[tuple[list[str], Needs]]:
    """Yield consecutive keys of one section with equal needs."""
    for (_, needs), pairs in groupby(_known().items(), key=lambda pair: (_parent(pair[0]), pair[1])):
        yield [key for key, _ in pairs], needs


def _known() -> dict[str, Needs]:
    """Return the needs by key; those of a cable model are the needs of its winch, or else of its span."""
    known: dict[str, Needs] = {}
    for key, needs in (*declarations(ScenarioSection), *part_declarations()):
        assert needs is not None
        name = key.removesuffix(" winch").removesuffix(" span")
        if name.endswith(".model"):  # each of its values has its own needs
            continue
        if name not in known or _everywhere(known[name]):
            known[name] = needs
    return known


def _everywhere(needs: Needs) -> bool:
    levels = {needs.support(use).level for use in USES}
    return levels <= {"yes", "-"} and not (needs.backend or needs.controller)


def _title(use: str) -> str:
    return TITLES.get(use, use.upper())


def _parent(key: str) -> str:
    return key.partition(": ")[0] if ": " in key else key.rpartition(".")[0]


def _cells(keys: list[str], needs: Needs) -> list[str]:
    supports = {use: needs.support(use) for use in USES}
    reasons: dict[str, list[str]] = {}
    for use, support in supports.items():
        if support.why:
            reasons.setdefault(support.why, []).append(_title(use))
    remarks = [f"{', '.join(uses)}: {why}" for why, uses in reasons.items()]
    required = [f"each run: the {role} must support it" for role in ("backend", "controller") if getattr(needs, role)]
    return [_names(keys), *(each.level for each in supports.values()), "<br>".join([*remarks, *required])]


def _names(keys: list[str]) -> str:
    """Return keys of one section as words."""
    parent = _parent(keys[0])
    names = [key.removeprefix(parent).lstrip(".: ") for key in keys]
    first = f"`{parent}`: " if parent else ""
    return first + ", ".join(f"`{name}`" for name in names)


def updated(text: str) -> str:
    """The page with its table written anew."""
    return rewritten(text, {"needs": needs_table, "everywhere": everywhere_list})


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text()))
