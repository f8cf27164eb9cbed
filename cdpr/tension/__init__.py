"""Tension distribution of one wrench at one pose: statuses, kernels, checks, tension stage, and fallback policy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.tension.status import Status

if TYPE_CHECKING:
    from cdpr.distribution import Distribution, distribute
else:  # their package is in a lower layer; users find them here, too
    from cdpr.lazy import lazily

    __getattr__ = lazily(__name__, dict.fromkeys(("Distribution", "distribute"), "cdpr.distribution"))

__all__ = ["Distribution", "Status", "distribute"]
