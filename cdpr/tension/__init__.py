"""Tension distribution of one wrench at one pose: statuses, kernels, checks, tension stage, and fallback policy.

Example:
    >>> import cdpr
    >>> cdpr.tension.Status.OK, int(cdpr.tension.Status.OK)
    (<Status.OK: 0>, 0)
"""

from cdpr.tension.status import Status

__all__ = ["Status"]
