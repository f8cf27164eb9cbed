"""What happened in a run, read from its rows."""

from __future__ import annotations

import numpy as np

from cdpr.log.run import Event
from cdpr.model.robot import Array
from cdpr.simulation.loop import Parts
from cdpr.tension.command import BEYOND
from cdpr.tension.stage import MEANING
from cdpr.tension.status import Status

# More events than anyone reads: the rest is counted in the last one.
MOST = 200


ANSWERS = {
    "best_effort": "the nearest wrench within the limits instead",
    "hold_tension": "the tensions before held instead",
    "stop": "stopped",
}
CLIPPED = "the solver minds no limits, its tensions were clipped to them"


def tension_events(status: Array, step: float, parts: Parts) -> list[Event]:
    """One event for each uninterrupted span of samples with the same status that is not OK.

    `status` is (K,), `step` is the control period, s, for which a sample's tensions are held.
    """
    meaning = {kind: f"{text}; {ANSWERS[parts.policy]}" for kind, text in MEANING.items()}
    if parts.output == "command":
        meaning[Status.NOT_FOUND] = f"{BEYOND}; it was clipped"
    elif not parts.respects_bounds and parts.policy == "best_effort":
        meaning[Status.NOT_FOUND] = CLIPPED
    end = (len(status) - 1) * step
    if not len(status):
        return []
    starts = np.flatnonzero(np.concatenate([[True], np.diff(status) != 0]))
    stops = np.concatenate([starts[1:], [len(status)]])
    spans = [(int(a), int(b)) for a, b in zip(starts, stops, strict=True) if status[a] != Status.OK]
    events = []
    for start, stop in spans[:MOST]:
        kind = Status(int(status[start]))
        text = f"{meaning[kind]} ({stop - start} samples)"
        events.append(Event(start * step, kind.name.lower(), text, until=min(stop * step, end)))
    if len(spans) > MOST:
        events.append(Event(spans[MOST][0] * step, "more", f"{len(spans) - MOST} further spans without distribution"))
    return events
