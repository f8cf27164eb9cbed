"""Intervals with slack cables, counted during a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.model.robot import Array
from cdpr.tension.checks import LIMIT_TOLERANCE, newton

MOST = 200  # intervals that are kept; further ones, such as of a chattering cable, are only counted
MOST_EVENTS = 20  # maximum number of events


class Interval(NamedTuple):
    """Interval, s, from the first slack sample of a cable (index) to the next taut one or the run's end."""

    start: float
    stop: float
    cable: int
    samples: int


class Slack(NamedTuple):
    """Intervals so far.

    Attributes:
        samples: number of samples with one or more slack cables.
        time: time of the last sample, s.
        kept: complete intervals, at most MOST.
        more: number of further intervals.
        open: intervals that include the last sample.
    """

    samples: int = 0
    time: float = 0.0
    kept: tuple[Interval, ...] = ()
    more: int = 0
    open: tuple[Interval, ...] = ()

    def added(self, time: Array, slack: NDArray[np.bool_]) -> Slack:
        """Return the intervals including the next samples: times (n,), s, and slack flags (n, m)."""
        last = float(time[-1])
        if not (self.open or slack.any()):
            return self._replace(time=last)
        lasting = {one.cable: one for one in self.open}
        before = np.zeros((1, slack.shape[1]), bool)
        before[0, list(lasting)] = True
        since, found = dict.fromkeys(lasting, 0), []  # start row of each interval
        for k, cable in np.argwhere(np.diff(np.concatenate([before, slack]), axis=0)).tolist():
            if slack[k, cable]:
                lasting[cable], since[cable] = Interval(float(time[k]), 0.0, cable, 0), k
            else:
                one = lasting.pop(cable)
                found.append(one._replace(stop=float(time[k]), samples=one.samples + k - since[cable]))
        kept = (*self.kept, *found)
        still = (one._replace(stop=last, samples=one.samples + len(slack) - since[i]) for i, one in lasting.items())
        samples = self.samples + int(np.count_nonzero(slack.any(axis=1)))
        return Slack(samples, last, kept[:MOST], self.more + max(len(kept) - MOST, 0), tuple(still))

    def intervals(self) -> list[Interval]:
        """Return the kept intervals in the order of time."""
        return sorted((*self.kept, *self.open))[:MOST]

    def figures(self, names: Sequence[str]) -> dict[str, Any]:
        """Return plain figures; `names` are those of all cables."""
        rows = [{"cable": names[one.cable], "from_s": one.start, "to_s": one.stop} for one in self.intervals()]
        return {"slack_samples": self.samples, "slack_intervals": rows}

    def events(self, names: Sequence[str]) -> list[Event]:
        """Return an event for each interval; cables that are slack together share one."""
        together: dict[tuple[float, float], list[Interval]] = {}
        for one in self.intervals():
            together.setdefault((one.start, one.stop), []).append(one)
        events = []
        for (start, stop), several in list(together.items())[:MOST_EVENTS]:
            cables, samples = [names[one.cable] for one in several], several[0].samples
            text = f"slack: {', '.join(cables)} ({samples} sample{'s' * (samples > 1)})"
            cable = cables[0] if len(cables) == 1 else None
            events.append(Event(start, "slack", text, cable=cable, until=stop if stop > start else None))
        if left := len(together) - len(events) + self.more:
            start = list(together)[min(MOST_EVENTS, len(together) - 1)][0]
            events.append(Event(start, "more", f"{left} further intervals with slack cables"))
        return events


def slack(tension: Array, header: Header) -> NDArray[np.bool_]:
    """Return True for slack tensions (n, m); never for robots whose limits allow compression."""
    limits = np.array([header.tension_min, header.tension_max])
    if (limits[0] < 0.0).any():
        return np.zeros(tension.shape, bool)
    return np.asarray(tension <= LIMIT_TOLERANCE * newton(limits))
