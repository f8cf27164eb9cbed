"""The pictures of a run: what any viewer draws of its rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.log.run import Run
from cdpr.scenario.events import limits_change
from cdpr.view import Pictures, pictures


def pictures_of(run: Run, rows: NDArray[np.int64] | None = None) -> Pictures:
    """Return the pictures of a run's rows: of all, or of those with these numbers (n,)."""
    shown = run if rows is None else run.picked(rows)
    changes = [event.time for event in run.events if limits_change({event.kind})]
    return pictures(
        run.header.subject,
        shown.time,
        shown.position,
        shown.orientation,
        tension=shown.cable_tension,
        command=shown.tension,
        desired=(shown.desired_position, shown.desired_orientation),
        force=shown.external[:, :3],
        limits_until=min(changes, default=np.inf),
    )
