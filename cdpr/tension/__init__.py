"""The tension-distribution problem: statuses, checks, box least squares, the infeasible policy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.tension.status import Status

if TYPE_CHECKING:
    from cdpr.distribution import Distribution, distribute

__all__ = ["Distribution", "Status", "distribute"]


def __getattr__(name: str) -> object:
    """Import what compiles only when it is asked for, so that `Status` stays light."""
    if name in ("Distribution", "distribute"):
        from cdpr import distribution  # their room lies below; users find them here, too

        return getattr(distribution, name)
    raise AttributeError(f"module 'cdpr.tension' has no attribute {name!r}")
