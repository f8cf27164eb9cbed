"""Closed-loop simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.simulation.simulate import simulate

if TYPE_CHECKING:
    from cdpr.simulation.simulation import Simulation
else:  # stepping needs more imports than running to the end
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, {"Simulation": "cdpr.simulation.simulation"})

__all__ = ["Simulation", "simulate"]
