"""Combination of two workspaces over the same cells: intersection, union or difference."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.kinds import combined
from cdpr.analysis.workspace.result import Workspace
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown

Inside = NDArray[np.bool_]

HOW: dict[str, Callable[[Inside, Inside], Inside]] = {
    "and": lambda first, second: first & second,
    "or": lambda first, second: first | second,
    "minus": lambda first, second: first & ~second,
}


def combine(first: Workspace, how: str, second: Workspace) -> Workspace:
    """Return the intersection ("and"), the union ("or") or the difference ("minus") of two workspaces.

    Its values are 1 inside and 0 outside.

    Raises:
        CdprError: if cells or attitudes differ.
    """
    if how not in HOW:
        raise CdprError(f"how: expected one of {', '.join(HOW)}, got {shown(how)}")
    here, there = first.region, second.region
    if here.shape != there.shape or not all(
        np.array_equal(a, b) for a, b in ((here.lower, there.lower), (here.upper, there.upper))
    ):
        raise CdprError("the workspaces are of different cells: give both the same --lower, --upper and --cells")
    if not np.array_equal(here.orientations, there.orientations):
        raise CdprError("the workspaces are of different attitudes: give both the same --orientation")
    inside = HOW[how](first.inside, second.inside)
    about: dict[str, Any] = {
        "question": first.about["question"],
        "of": [{"kind": each.kind.name, "robot": each.robot, **each.about} for each in (first, second)],
        "how": how,
        "method": "combined",
        "limited_by": {},
        "source": first.about.get("source", {}),
    }
    kind = combined(f"{first.kind.name} {how} {second.kind.name}")
    boundary, nothing = first.boundary | second.boundary, np.full(inside.shape, -1, dtype=np.int64)
    evaluated = first.evaluated & second.evaluated
    return Workspace(kind, first.robot, here, inside.astype(np.float64), inside, boundary, nothing, evaluated, about)
