"""Workspaces: where a robot can hold, pull and accelerate.

At a pose, `measure` asks every facet of what the cables can exert (`facets`, `assess`) how far it is from what must be
exerted (`required`). A `region` is a box of positions, cut into cells; a `workspace` is what was found there, of one of
several `kinds`; an `oracle` asks linear programs about the same poses.
"""

from __future__ import annotations

from cdpr.workspace.measure import Measured, measure
from cdpr.workspace.question import Question
from cdpr.workspace.regions import Region, region
from cdpr.workspace.required import Required, box, ellipsoid, point, vertices, zonotope
from cdpr.workspace.result import Workspace, load_workspace, workspace

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
