"""Frames of a run for 3D views."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.scenario.events import limits_change
from cdpr.scene import Pictures, pictures

RATE = 60.0  # Hz in simulated time: the refresh rate of screens
MOST = 1500  # frames; the player interpolates linearly between them


def frames(run: Run) -> NDArray[np.int64]:
    """Return the rows (n,) to draw: evenly spaced rows, and for each event the row before and the row at it."""
    last = len(run.rows) - 1
    count = min(last + 1, MOST, int(RATE * (run.span[1] - run.span[0])) + 2)
    even = np.rint(np.linspace(0, last, max(count, 2))).astype(np.int64)
    times = np.array([event.time for event in run.events][:MOST] or [0.0])
    at = np.ceil(times / run.header.log_step - 1e-9).astype(np.int64)
    chosen: NDArray[np.int64] = np.unique(np.clip(np.concatenate([even, at, at - 1]), 0, last))
    return chosen


def pictures_of(run: Run, rows: NDArray[np.int64] | None = None) -> Pictures:
    """Return the frames of all rows of a run, or of the rows with these indices (n,)."""
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
        unwound=shown.unstretched_length if run.header.spans else None,
        readings=_readings(shown),
        limits_until=min(changes, default=np.inf),
    )


def _readings(run: Run) -> dict[str, Array]:
    """Return the columns of sensors that are drawn."""
    known = run.header.layout.fields
    return {each.column: run[each.column] for each in run.header.subject.sensors if each.column in known}
