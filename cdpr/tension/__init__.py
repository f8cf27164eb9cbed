"""Tension distribution of one wrench at one pose: statuses, kernels, checks, tension stage, and fallback policy.

Example:
    >>> import cdpr
    >>> cdpr.tension.Status.OK, int(cdpr.tension.Status.OK)
    (<Status.OK: 0>, 0)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.tension.status import Status

if not TYPE_CHECKING:  # modules are loaded when first used
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__)

__all__ = ["Status"]
