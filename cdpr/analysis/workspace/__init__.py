"""Workspaces: poses at which a robot can hold, pull and accelerate.

At a pose, `measure` computes the distance of the required wrenches (`required`) from every facet of the available ones
(`facets`, `assess`). A `region` is a box of positions divided into cells. A `workspace` is the result there, of one of
several `kinds`; an `oracle` checks the same poses by linear programs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.analysis.workspace.measure import Measured, measure
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import Region, region
from cdpr.analysis.workspace.required import Required, box, ellipsoid, point, vertices, zonotope

if TYPE_CHECKING:
    from cdpr.analysis.workspace.result import Workspace, load_workspace, workspace
else:  # the analysis of a motion does not compute workspaces
    from cdpr.base.lazy import lazily

    _RESULT = "cdpr.analysis.workspace.result"
    __getattr__ = lazily(__name__, {"Workspace": _RESULT, "load_workspace": _RESULT, "workspace": _RESULT})

__all__ = [
    "Measured",
    "Question",
    "Region",
    "Required",
    "Workspace",
    "box",
    "ellipsoid",
    "load_workspace",
    "measure",
    "point",
    "region",
    "vertices",
    "workspace",
    "zonotope",
]
