"""What is told of a run: what its scenario let happen, and what its rows show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr.log.run import Event, Header
from cdpr.model.reach import Reach
from cdpr.model.robot import Array
from cdpr.scenario.event_schema import CableBreak, CableFault, Load, ScenarioEvent, Sine, TensionLimits, first_sample
from cdpr.simulation.loop import Parts
from cdpr.simulation.schedule import power_off
from cdpr.tension.command import BEYOND
from cdpr.tension.policy import CLIPPED, FALLBACK
from cdpr.tension.stage import MEANING
from cdpr.tension.status import Status

# More events than anyone reads: the rest is counted in the last one.
MOST = 200


def tension_events(status: NDArray[np.generic], step: float, parts: Parts) -> list[Event]:
    """One event for each uninterrupted span of samples with the same status that is not OK.

    `status` is (K,), `step` is the control period, s, for which a sample's tensions are held.
    """
    meaning = {kind: f"{text}; {FALLBACK.get(parts.policy, 'stopped')}" for kind, text in MEANING.items()}
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
        text = f"{meaning[kind]} ({stop - start} sample{'s' * (stop - start > 1)})"
        until = min(stop * step, end)
        events.append(Event(start * step, kind.name.lower(), text, until=until if until > start * step else None))
    if len(spans) > MOST:
        events.append(Event(spans[MOST][0] * step, "more", f"{len(spans) - MOST} further spans without distribution"))
    return events


def limit_events(reach: Reach, header: Header) -> list[Event]:
    """One event for each kind of limit that cables left."""
    return [Event(one.first * header.control_step, "limit", one.text(header.cables)) for one in reach.told()]


def marks(scheduled: Sequence[ScenarioEvent], step: float) -> list[int]:
    """Return the samples whose rows `scheduled_events` needs."""
    return [first_sample(event.time, step) for event in scheduled if isinstance(event, CableFault)]


def scheduled_events(
    scheduled: Sequence[ScenarioEvent], samples: int, marked: Mapping[int, Array], header: Header
) -> list[Event]:
    """Return the scenario's events that came to pass within so many samples.

    `marked` holds the rows of those that `marks` names, as far as they were made.
    """
    step = header.control_step
    came = [one for one in scheduled if round(one.time / step) < samples]
    return [event for one in came for event in _tell(one, samples, marked, header)]


def _tell(event: ScenarioEvent, samples: int, marked: Mapping[int, Array], header: Header) -> Iterator[Event]:
    """Yield what there is to say of one event, each at the sample at which it acts."""
    step = header.control_step
    k = first_sample(event.time, step)
    time = k * step
    if isinstance(event, Load):
        end = None
        if event.duration is not None:
            end = min(first_sample(event.time + event.duration, step), samples - 1) * step
        swing = f" times a sine of {event.frequency:g} Hz" if isinstance(event, Sine) else ""
        yield Event(
            time, event.type, f"external force {_list(event.force)} N, moment {_list(event.moment)} N m{swing}", end
        )
    elif isinstance(event, CableFault):
        learns = first_sample(event.time + event.detected_after, step)
        known = learns * step
        broken = isinstance(event, CableBreak)
        what = "breaks"
        if not broken and k in marked:
            tension = marked[k][header.layout.columns["tension"]][header.cables.index(str(event.cable))]
            what = f"jams at {tension:.5g} N"
        text = f"cable '{event.cable}' {what}" + ("" if known > time else ", known at once")
        yield Event(time, event.type, text, cable=str(event.cable))
        if known > time and learns < samples:
            what = "broken" if broken else "jammed"
            yield Event(known, "detected", f"the distribution learns that cable '{event.cable}' is {what}")
    elif isinstance(event, TensionLimits):
        limits = [f"{key} {value:g} N" for key, value in (("min", event.min), ("max", event.max)) if value is not None]
        whose = "all cables" if event.cable is None else f"cable '{event.cable}'"
        yield Event(time, event.type, f"the tension limits of {whose} become {', '.join(limits)}")
    else:
        controlled = f", at rest within {event.stopping_time:g} s" if event.category != 0 else ""
        yield Event(time, event.type, f"emergency stop of category {event.category}{controlled}")
        if event.category != 2:
            off = first_sample(power_off(event, step), step) * step
            yield Event(off, "power_off", "the drives are without power: no tensions but in jammed cables")


def _list(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"
