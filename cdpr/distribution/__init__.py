"""Many poses, many wrenches, many solvers: distributions by the thousand, and all that a wrench at a pose admits."""

from cdpr.distribution.admissible_set import Admissible, admissible
from cdpr.distribution.distributions import Distribution, distribute

__all__ = ["Admissible", "Distribution", "admissible", "distribute"]
