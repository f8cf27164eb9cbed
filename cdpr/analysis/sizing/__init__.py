"""Sizing of cables, drums and motors from planned motions and runs.

A `Duty` is the motion and load of a robot's cables. `demands` computes the figures of each cable from it, and a
`Sizing` holds those of several duties and the worst of each.
"""

from __future__ import annotations

from cdpr.analysis.sizing.demands import Demands, demands
from cdpr.analysis.sizing.duty import Duty, over_workspace, with_one_broken
from cdpr.analysis.sizing.sizes import Sizing, sizing

__all__ = ["Demands", "Duty", "Sizing", "demands", "over_workspace", "sizing", "with_one_broken"]
