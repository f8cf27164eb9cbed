"""Events reported for a run: those of its scenario, and those found in its rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.mechanics.contacts import passing
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.mechanics.reach import Exceeded
from cdpr.model.robot import Array
from cdpr.scenario.events import ScenarioEvent, first_sample
from cdpr.scenario.events.event import ClearanceMonitor
from cdpr.simulation.parts import Parts
from cdpr.tension.command import BEYOND
from cdpr.tension.policy import CLIPPED, FALLBACK
from cdpr.tension.stage import MEANING
from cdpr.tension.status import Status

if TYPE_CHECKING:
    from cdpr.mechanics.closest import Closest

UNBALANCED = 0.1  # share of the weight from which the start is reported
# More events would not be read: the last one counts the rest.
MOST = 200


def tension_events(status: NDArray[np.generic], step: float, parts: Parts, refusal: str = "") -> list[Event]:
    """Return one event for each uninterrupted span of samples with the same status other than OK.

    Args:
        status: (K,) status of each sample.
        step: control period, s, for which the tensions of a sample are held.
        parts: parts of the loop.
        refusal: first rejection of a solver's answer, as `cdpr.tension.stage.refusal` returns it.
    """
    meaning = {kind: f"{text}; {FALLBACK.get(parts.policy, 'stopped')}" for kind, text in MEANING.items()}
    if parts.output != "wrench":
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
        if refusal and kind == Status.NOT_FOUND:
            text, refusal = f"{text}; the first that was refused: {refusal}", ""
        until = min(stop * step, end)
        events.append(Event(start * step, kind.name.lower(), text, until=until if until > start * step else None))
    if len(spans) > MOST:
        events.append(Event(spans[MOST][0] * step, "more", f"{len(spans) - MOST} further spans without distribution"))
    return events


def start_events(first: Array, header: Header, parts: Parts) -> list[Event]:
    """Return an event if a controller commands winches, and the cables do not hold the platform at the start.

    Args:
        first: first row of the run.
        header: header of the run.
        parts: parts of the loop.
    """
    if parts.output != "winch" or header.loaded:
        return []
    robot, columns = parts.robot, header.layout.columns
    state = first[header.layout.span("position", "angular_velocity")].copy()
    state[7:] = 0.0
    weight = required_wrench(robot, state, np.array(header.gravity))
    wrench = wrench_matrix(robot, state) @ first[columns["cable_tension"]]
    if "bending_wrench" in columns:
        wrench += first[columns["bending_wrench"]]
    rows = list(robot.rows)
    unit = np.repeat([1.0, robot.characteristic_length], 3)[rows]
    needed, left = (float(np.linalg.norm(each[rows] / unit)) for each in (weight, weight - wrench))
    if not left > UNBALANCED * needed:
        return []
    text = (
        f"the cables do not hold the platform at the start: {left:.4g} N of {needed:.4g} N are not balanced, and it "
        "moves until they are; start with cables under tension, or at rest (initial.equilibrium)"
    )
    return [Event(0.0, "start", text)]


def limit_events(exceeded: Sequence[Exceeded], header: Header) -> list[Event]:
    """Return one event for each kind of limit that cables exceeded."""
    return [Event(one.first * header.control_step, "limit", one.text(header.cables)) for one in exceeded]


def contact_events(closest: Closest, guarding: Sequence[tuple[ScenarioEvent, ClearanceMonitor]]) -> list[Event]:
    """Return one event for each uninterrupted span of samples with too small clearance, by guard and level."""
    events = []
    for i, (event, guard) in enumerate(guarding):
        spans = closest.spans(i)
        for span in spans[:MOST]:
            first, least = closest.name(span.first), closest.name(span.least)
            near = f"come within {guard.clearance:g} m" if guard.clearance else "touch"
            of = f" of {least}" if least != first else ""
            count = f"{span.samples} sample{'s' * (span.samples > 1)}"
            lowest = span.least.clearance
            through = passing(least, lowest)
            how = through or f"clearance down to {lowest:.4g} m{of}"
            begin = "" if through and first == least and not guard.clearance else f"{first} {near}: "
            text = f"{begin}{how} at {span.least.time:.6g} s"
            until = span.until if span.until > span.first.time else None
            events.append(Event(span.first.time, event.kind(), f"{text} ({count})", until=until))
        if len(spans) > MOST:
            text = f"{len(spans) - MOST} further intervals in which cables are too close"
            events.append(Event(spans[MOST].first.time, "more", text))
    return events


def marks(scheduled: Sequence[ScenarioEvent], step: float) -> list[int]:
    """Return the samples with rows that `scheduled_events` needs."""
    return [first_sample(event.time, step) for event in scheduled if event.wants_tensions]


def scheduled_events(
    scheduled: Sequence[ScenarioEvent], samples: int, marked: Mapping[int, Array], header: Header
) -> list[Event]:
    """Return the scenario's events that happened within these samples, in order.

    `marked` holds the computed rows of the samples that `marks` returns.
    """
    step, columns = header.control_step, header.layout.columns["tension"]

    def tensions(k: int) -> dict[str, float]:
        return dict(zip(header.cables, marked[k][columns].tolist(), strict=True)) if k in marked else {}

    came = [one for one in sorted(scheduled, key=lambda one: one.time) if first_sample(one.time, step) < samples]
    return [event for one in came for event in one.event_log(step, samples, tensions(first_sample(one.time, step)))]
