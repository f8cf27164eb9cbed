"""The tension-distribution problem: statuses, checks, box least squares, the infeasible policy, `distribute`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.tension.status import Status

if TYPE_CHECKING:
    from cdpr.tension.distribution import Distribution, distribute
else:  # what compiles, only when it is asked for, so that `Status` stays light
    from cdpr.lazy import lazily

    __getattr__ = lazily(__name__, dict.fromkeys(("Distribution", "distribute"), "cdpr.tension.distribution"))

__all__ = ["Distribution", "Status", "distribute"]
