"""What cables, drums and motors must bear: figures to buy by, of motions that are foreseen and of runs.

A `Duty` is what a robot's cables do over time; `demands` makes of it the figures of each cable, and a `Sizing` holds
those of several duties and the worst of each.
"""

from __future__ import annotations

from cdpr.sizing.demands import Demands, demands
from cdpr.sizing.duty import Duty, over_workspace, with_one_broken
from cdpr.sizing.sizes import Sizing, sizing

__all__ = ["Demands", "Duty", "Sizing", "demands", "over_workspace", "sizing", "with_one_broken"]
