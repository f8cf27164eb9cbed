"""Bodies that events attach to the platform, as a function of events and sample."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import chain

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.mechanics.attachments import Attachment, with_attachments
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.events.event import AttachmentSpan
from cdpr.simulation.parts import Parts
from cdpr.simulation.sample import Sample


class AttachedBodies(ABC):
    """Bodies on the platform at each sample."""

    def __init__(self) -> None:
        self._bodies: tuple[Attachment, ...] = ()
        self._spans: list[AttachmentSpan] = []
        self._known: dict[int, tuple[ScenarioEvent, AttachmentSpan | None]] = {}

    def plan(self, events: Sequence[ScenarioEvent], step: float) -> set[int]:
        """Replace the events; return the samples at which bodies are attached or removed."""
        known = self._known  # an event keeps its body when the plan is renewed
        self._known = {id(event): known.get(id(event)) or (event, event.attachment(step)) for event in events}
        self._spans = [span for _, span in self._known.values() if span is not None]
        times = chain.from_iterable((span.first, span.end) for span in self._spans)
        return {int(k) for k in times if np.isfinite(k)}

    def update(self, k: int) -> None:
        """Attach the bodies of sample k, and remove others."""
        bodies = tuple(span.body for span in self._spans if span.first <= k < span.end)
        if bodies != self._bodies:
            self._change(self._bodies, bodies)
            self._bodies = bodies

    def reset(self) -> None:
        """Remove all bodies, before the first sample."""
        self.update(-1)

    @abstractmethod
    def _change(self, before: Sequence[Attachment], bodies: Sequence[Attachment]) -> None:
        """Replace the bodies; an error has no effect."""


class LoopBodies(AttachedBodies):
    """Bodies on the platform of a loop.

    A change applies to the backend, the observation of the plant and, for known bodies, the controller. Pose and twist
    of the platform's origin do not change: a body joins and leaves at the velocity of the platform. Its energy at that
    time is added to the column `load_energy`.

    Args:
        parts: parts of the loop.
        present: present sample.
        rebind: function that takes the operations of the backend again.
    """

    def __init__(self, parts: Parts, present: Sample, rebind: Callable[[], None]) -> None:
        super().__init__()
        self._parts, self._present, self._rebind = parts, present, rebind
        self._plant = parts.backend.robot

    def reset(self) -> None:
        """Remove all bodies, and reset their energy."""
        super().reset()
        if self._spans and self._present.layout.has("loaded"):
            self._present.view("load_energy")[:] = 0.0

    def _change(self, before: Sequence[Attachment], bodies: Sequence[Attachment]) -> None:
        parts, present = self._parts, self._present
        try:
            self._load(bodies)
            self._inform(before, bodies)
        except CdprError:
            with suppress(CdprError):
                self._load(before)
            raise
        self._rebind()
        present.renew(with_attachments(parts.robot, bodies))
        present.weigh()

    def _load(self, bodies: Sequence[Attachment]) -> None:
        """Attach the bodies to the plant."""
        try:
            self._parts.backend.load(with_attachments(self._plant, bodies))
        except CdprError as error:  # names keys of the robot
            masses = ", ".join(f"{body.mass:g}" for body in bodies) or "no"
            raise type(error)(f"the platform with bodies of {masses} kg that events attach: {error}") from None

    def _inform(self, before: Sequence[Attachment], bodies: Sequence[Attachment]) -> None:
        """Inform the controller of changes of known bodies."""
        parts, known = self._parts, [body for body in bodies if body.known]
        if known == [body for body in before if body.known]:
            return
        if not parts.controller.renew(with_attachments(parts.perceived_robot, known)):
            raise PluginError(
                f"{type(parts.controller).__name__} cannot take the mass of a known body during a run: set known: "
                "false, or choose another controller"
            )


class SurveyBodies(AttachedBodies):
    """Bodies on the platform of a robot without a plant.

    Args:
        robot: robot without bodies.
        inertial: (13,) as `Robot.inertial`, live.
    """

    def __init__(self, robot: Robot, inertial: Array) -> None:
        super().__init__()
        self._robot, self._inertial = robot, inertial

    def _change(self, before: Sequence[Attachment], bodies: Sequence[Attachment]) -> None:
        self._inertial[:] = with_attachments(self._robot, bodies).inertial
