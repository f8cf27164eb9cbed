"""Many poses, many wrenches: distributions by the thousand, and all that a wrench at a pose admits."""

from cdpr.distribution.distributions import Distribution, distribute

__all__ = ["Distribution", "distribute"]
