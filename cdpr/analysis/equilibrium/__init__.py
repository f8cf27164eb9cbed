"""Poses at rest for given lengths, drum angles or tensions, and the lengths that make a platform rest at a pose."""

from cdpr.analysis.equilibrium.at_rest import equilibria, equilibrium
from cdpr.analysis.equilibrium.compensation import Compensation, compensated_lengths
from cdpr.mechanics.equilibrium import Equilibrium

__all__ = ["Compensation", "Equilibrium", "compensated_lengths", "equilibria", "equilibrium"]
