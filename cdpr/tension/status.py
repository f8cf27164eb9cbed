"""Status of a tension solver's answer."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Status codes, each with a single meaning."""

    OK = 0  # the tensions balance the wrench within the limits
    INFEASIBLE = 1  # no tensions within the limits balance the wrench
    NOT_FOUND = 2  # no usable answer: the method gave up, or its answer failed the checks
    UNSUPPORTED = 3  # the method does not apply to this robot or pose
    BAD_INPUT = 4  # not finite, wrong shape, or contradictory limits

    def __str__(self) -> str:
        return self.name


# The same as plain integers, for compiled code. A kernel with a count returns minus a status on failure.
OK = int(Status.OK)
INFEASIBLE = int(Status.INFEASIBLE)
NOT_FOUND = int(Status.NOT_FOUND)
UNSUPPORTED = int(Status.UNSUPPORTED)
BAD_INPUT = int(Status.BAD_INPUT)
