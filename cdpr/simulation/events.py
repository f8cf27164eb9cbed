"""What happened in a run, read from its rows."""

from __future__ import annotations

import numpy as np

from cdpr.log.run import Event
from cdpr.model.robot import Array
from cdpr.plugins.controller import Output
from cdpr.tension.command import BEYOND
from cdpr.tension.stage import MEANING
from cdpr.tension.status import Status

# More events than anyone reads: the rest is counted in the last one.
MOST = 200


CLIPPED = "the solver minds no limits; tensions beyond them were clipped"


def tension_events(status: Array, step: float, respects_limits: bool, output: Output = "wrench") -> list[Event]:
    """One event for each uninterrupted span of samples with the same status that is not OK.

    `status` is (K,), `step` is the control period, s, for which a sample's tensions are held; `output` is what the
    controller puts out.
    """
    meaning = MEANING if respects_limits else {**MEANING, Status.NOT_FOUND: CLIPPED}
    if output == "command":
        meaning = {**MEANING, Status.NOT_FOUND: f"{BEYOND}; it was clipped"}
    if not len(status):
        return []
    starts = np.flatnonzero(np.concatenate([[True], np.diff(status) != 0]))
    stops = np.concatenate([starts[1:], [len(status)]])
    spans = [(int(a), int(b)) for a, b in zip(starts, stops, strict=True) if status[a] != Status.OK]
    events = []
    for start, stop in spans[:MOST]:
        kind = Status(int(status[start]))
        text = f"{meaning[kind]} ({stop - start} samples)"
        events.append(Event(start * step, kind.name.lower(), text, until=stop * step))
    if len(spans) > MOST:
        events.append(Event(spans[MOST][0] * step, "more", f"{len(spans) - MOST} further spans without distribution"))
    return events
