"""The closed loop and what runs it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.simulation.simulate import simulate

if TYPE_CHECKING:
    from cdpr.simulation.simulation import Simulation
else:  # what is steered needs more than what runs to its end
    from cdpr.lazy import lazily

    __getattr__ = lazily(__name__, {"Simulation": "cdpr.simulation.simulation"})

__all__ = ["Simulation", "simulate"]
