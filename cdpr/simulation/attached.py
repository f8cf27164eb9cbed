"""Bodies that events attach to the platform of a loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np

from cdpr.mechanics.attachments import Attachment, with_attachments
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.events.event import AttachmentSpan
from cdpr.simulation.parts import Parts
from cdpr.simulation.sample import Sample


class AttachedBodies:
    """Bodies on the platform at each sample, a function of the events and the sample.

    A change applies to the backend, the observation of the plant and, for known bodies, the controller. Pose and twist
    of the platform's origin do not change: a body joins and leaves at the velocity of the platform. Its energy at that
    time is added to the column `load_energy`.

    Args:
        parts: parts of the loop.
        present: present sample.
        rebind: function that takes the operations of the backend again.
    """

    def __init__(self, parts: Parts, present: Sample, rebind: Callable[[], None]) -> None:
        self._parts, self._present, self._rebind = parts, present, rebind
        self._spans: list[AttachmentSpan] = []
        self._bodies: tuple[Attachment, ...] = ()
        self._known: dict[int, tuple[ScenarioEvent, AttachmentSpan | None]] = {}
        self._plant = parts.backend.robot

    def plan(self, events: Sequence[ScenarioEvent], step: float) -> set[int]:
        """Replace the events; return the samples at which bodies are attached or removed."""
        known = self._known  # an event keeps its body when the plan is renewed
        self._known = {id(event): known.get(id(event)) or (event, event.attachment(step)) for event in events}
        self._spans = [span for _, span in self._known.values() if span is not None]
        times = chain.from_iterable((span.first, span.end) for span in self._spans)
        return {int(k) for k in times if np.isfinite(k)}

    def update(self, k: int) -> None:
        """Attach the bodies of sample k; none for a negative k."""
        bodies = tuple(span.body for span in self._spans if span.first <= k < span.end)
        if k < 0 and self._spans:
            self._present.view("load_energy")[:] = 0.0
        if bodies != self._bodies:
            self._change(bodies)

    def _change(self, bodies: tuple[Attachment, ...]) -> None:
        parts, present = self._parts, self._present
        known = [body for body in bodies if body.known]
        changed = known != [body for body in self._bodies if body.known]
        self._bodies = bodies
        parts.backend.load(with_attachments(self._plant, bodies))
        self._rebind()
        present.renew(with_attachments(parts.robot, bodies))
        present.weigh()
        if changed:
            parts.controller.renew(with_attachments(parts.nominal or parts.robot, known))
