"""The tension-distribution problem: statuses, checks, box least squares, the infeasible policy."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """What a solver says of its answer; each has one meaning."""

    OK = 0  # the tensions balance the wrench within the limits
    INFEASIBLE = 1  # no tensions within the limits balance the wrench
    NOT_FOUND = 2  # the method gave up without an answer
    UNSUPPORTED = 3  # the method does not apply to this robot or pose
    BAD_INPUT = 4  # not finite, wrong shape, or limits that contradict each other


__all__ = ["Status"]
