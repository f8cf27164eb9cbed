"""The closed loop and what runs it."""

from cdpr.simulation.simulate import simulate
from cdpr.simulation.simulation import Simulation

__all__ = ["Simulation", "simulate"]
