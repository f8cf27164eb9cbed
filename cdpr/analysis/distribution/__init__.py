"""Tension distribution for many poses, wrenches and solvers, and the set of admissible tensions."""

from cdpr.analysis.distribution.admissible_set import Admissible, admissible
from cdpr.analysis.distribution.distributions import Distribution, distribute

__all__ = ["Admissible", "Distribution", "admissible", "distribute"]
