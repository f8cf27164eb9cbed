"""The desired motion: quintic segments through knots, held at the end."""

from cdpr.trajectory.trajectory import Knot, Trajectory, hold, through

__all__ = ["Knot", "Trajectory", "hold", "through"]
