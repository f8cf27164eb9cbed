"""The tension-distribution problem: statuses, checks, box least squares, the infeasible policy."""

from cdpr.tension.status import Status

__all__ = ["Status"]
