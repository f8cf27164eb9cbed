"""Tension distribution of one wrench at one pose: statuses, kernels, checks, tension stage, and fallback policy."""

from cdpr.tension.status import Status

__all__ = ["Status"]
