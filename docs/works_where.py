"""Write the table of docs/works_where.md. Run: python docs/works_where.py. A test holds the page to it."""

from __future__ import annotations

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
    """Return the table of keys: their support by each use, with reasons."""
    known = dict.fromkeys((*declarations(ScenarioSection), *part_declarations()))
    titles = ("key", *(TITLES.get(use, use.upper()) for use in USES), "remarks")
    groups = groupby(known, key=lambda pair: (_parent(pair[0]), pair[1]))
    return table(titles, (_cells([key for key, _ in pairs], needs) for (_, needs), pairs in groups))


def _parent(key: str) -> str:
    return key.partition(": ")[0] if ": " in key else key.rpartition(".")[0]


def _cells(keys: list[str], needs: Needs | None) -> list[str]:
    assert needs is not None
    supports = [needs.support(use) for use in USES]
    required = [f"the {role} must support it" for role in ("backend", "controller") if getattr(needs, role)]
    remarks = dict.fromkeys([each.why for each in supports if each.why] + required)
    parent = _parent(keys[0])
    names = [key.removeprefix(parent).lstrip(".: ") for key in keys]
    first = f"`{parent}`: " if parent else ""
    return [first + ", ".join(f"`{name}`" for name in names), *(each.level for each in supports), "; ".join(remarks)]


def updated(text: str) -> str:
    """The page with its table written anew."""
    return rewritten(text, {"needs": needs_table})


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text()))
