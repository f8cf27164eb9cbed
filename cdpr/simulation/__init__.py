"""Closed-loop simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cdpr.simulation.simulation import Simulation
    from cdpr.simulation.whole_run import simulate
else:  # `cdpr validate` only needs the checks of a loop
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(
        __name__, {"Simulation": "cdpr.simulation.simulation", "simulate": "cdpr.simulation.whole_run"}
    )

__all__ = ["Simulation", "simulate"]
