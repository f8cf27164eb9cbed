"""The closed loop and what runs it."""

from cdpr.simulation.simulate import simulate

__all__ = ["simulate"]
