"""Tension distribution for many poses, wrenches and solvers, and the set of admissible tensions."""

from cdpr.distribution.admissible_set import Admissible, admissible
from cdpr.distribution.distributions import Distribution, distribute

__all__ = ["Admissible", "Distribution", "admissible", "distribute"]
