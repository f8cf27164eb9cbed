"""Steps that stepper motors lost, counted during a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.model.robot import Array

TOGETHER = 0.1  # s: losses of one cable with shorter distances are one event
MOST = 200  # intervals that are kept; further ones are only counted
MOST_EVENTS = 20


class Loss(NamedTuple):
    """Interval, s, from the first to the last sample at which a cable (index) lost steps."""

    start: float
    stop: float
    cable: int
    steps: int  # full steps, positive if the cable was paid out


class LostSteps(NamedTuple):
    """Losses so far.

    Attributes:
        last: (m,) lost full steps of each cable at the last sample, NaN for winches without steps; None before it.
        kept: intervals in the order of their start, at most MOST.
        more: number of further intervals.
    """

    last: Array | None = None
    kept: tuple[Loss, ...] = ()
    more: int = 0

    def added(self, time: Array, lost: Array) -> LostSteps:
        """Return the losses including the next samples: times (n,), s, and lost steps (n, m)."""
        before = lost[:1] if self.last is None else self.last[None]
        change = np.nan_to_num(np.diff(np.concatenate([before, lost]), axis=0))
        kept, more = list(self.kept), self.more
        latest = {one.cable: i for i, one in enumerate(kept)}
        for k, cable in np.argwhere(change).tolist():
            at, steps = float(time[k]), int(change[k, cable])
            i = latest.get(cable)
            if i is not None and at - kept[i].stop < TOGETHER:
                kept[i] = kept[i]._replace(stop=at, steps=kept[i].steps + steps)
            elif len(kept) < MOST:
                latest[cable] = len(kept)
                kept.append(Loss(at, at, cable, steps))
            else:
                more += 1
        return LostSteps(lost[-1].copy(), tuple(kept), more)

    def figures(self, names: Sequence[str]) -> dict[str, Any]:
        """Return plain figures, {} without stepper motors; `names` are those of all cables."""
        if self.last is None or np.isnan(self.last).all():
            return {}
        rows = [
            {"cable": names[one.cable], "from_s": one.start, "to_s": one.stop, "steps": one.steps} for one in self.kept
        ]
        return {"lost_steps": int(np.nansum(np.abs(self.last))), "lost_steps_intervals": rows}

    def events(self, names: Sequence[str]) -> list[Event]:
        """Return an event for each interval."""
        events = []
        for one in self.kept[:MOST_EVENTS]:
            name, way = names[one.cable], "paid out" if one.steps > 0 else "wound in"
            lost = f"loses {abs(one.steps)} full steps: its cable is {way} unnoticed"
            text = f"the stepper of cable '{name}' {lost if one.steps else 'slips and returns'}"
            until = one.stop if one.stop > one.start else None
            events.append(Event(one.start, "lost_steps", text, cable=name, until=until))
        if left := len(self.kept) - len(events) + self.more:
            start = self.kept[min(MOST_EVENTS, len(self.kept) - 1)].start
            events.append(Event(start, "more", f"{left} further losses of steps"))
        return events


def lost_steps(found: LostSteps, header: Header, rows: Array) -> LostSteps:
    """Return the losses including the next samples of a run, (n, width); unchanged for runs without stepper motors."""
    if not header.layout.has("steppers") or not len(rows):
        return found
    return found.added(rows[:, 0], np.asarray(rows[:, header.layout.columns["lost_steps"]]))
