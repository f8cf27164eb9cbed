"""Bodies that events attach to the platform, as a function of events and sample."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.mechanics.attachments import Attachment, with_attachments
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.snapshots import Saved, put_back, save
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
            self._change(k, bodies)
            self._bodies = bodies

    def reset(self) -> None:
        """Remove all bodies, before the first sample."""
        self.update(-1)

    def can_undo(self, k: int) -> bool:
        """Return True if a body attached at sample k can be removed at this sample, as if it had never been there."""
        return False

    def snapshot(self, k: int) -> Mapping[str, Any]:
        """Return what further changes at the present sample k need."""
        return {}

    def restore(self, snapshot: Mapping[str, Any]) -> None:  # noqa: B027 - an optional hook
        """Restore a snapshot, after the bodies."""

    @abstractmethod
    def _change(self, k: int, bodies: tuple[Attachment, ...]) -> None:
        """Replace the bodies at sample k; an error has no effect."""


@dataclass(frozen=True, eq=False)
class Unchanged:
    """Plant before the first change of its bodies at a sample.

    Attributes:
        sample: number of the sample.
        bodies: bodies on the platform.
        plant: snapshot of the backend; None if it does not support that.
        energies: energies in the row.
    """

    sample: int
    bodies: tuple[Attachment, ...]
    plant: object
    energies: Saved


class LoopBodies(AttachedBodies):
    """Bodies on the platform of a loop.

    A change applies to the backend, the observation of the plant and, for known bodies, the controller. Pose and twist
    of the platform's origin do not change: a body joins and leaves at the velocity of the platform. Its energy at that
    time is added to the column `load_energy`.

    Each change rounds the state of a plant. All changes of a sample therefore begin at the plant before the first one,
    so that a saved session, which makes one change, repeats the bits.

    Args:
        parts: parts of the loop.
        present: present sample.
        rebind: function that takes the operations of the backend again.
    """

    def __init__(self, parts: Parts, present: Sample, rebind: Callable[[], None]) -> None:
        super().__init__()
        self._parts, self._present, self._rebind = parts, present, rebind
        self._plant = parts.backend.robot
        self._unchanged: Unchanged | None = None
        self._rounded = False  # True if the plant differs from that of `_unchanged`

    def can_undo(self, k: int) -> bool:
        """Return True if the plant before the changes of sample k is known."""
        return self._unchanged is not None and self._unchanged.sample == k and self._unchanged.plant is not None

    def snapshot(self, k: int) -> Mapping[str, Any]:
        """Return what further changes at the present sample k need."""
        return {"unchanged": self._unchanged, "rounded": self._rounded} if self.can_undo(k) else {}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a snapshot, after the bodies."""
        self._unchanged, self._rounded = snapshot.get("unchanged"), snapshot.get("rounded", False)

    def reset(self) -> None:
        """Remove all bodies, and reset their energy."""
        super().reset()
        self._unchanged = None
        if self._spans and self._present.layout.has("loaded"):
            self._present.view("load_energy")[:] = 0.0

    def _change(self, k: int, bodies: tuple[Attachment, ...]) -> None:
        before, present, unchanged = self._bodies, self._present, self._at(k)
        try:
            self._take(unchanged, bodies)
            self._inform(before, bodies)
        except CdprError:
            with suppress(CdprError):
                self._take(unchanged, before)
            raise
        self._rebind()
        present.renew(with_attachments(self._parts.robot, bodies))
        put_back(unchanged.energies, present.weighed)
        if bodies != unchanged.bodies:
            present.weigh()

    def _at(self, k: int) -> Unchanged:
        """Return the plant before the first change of sample k, which may be the present one."""
        if self._unchanged is None or self._unchanged.sample != k:
            plant = None
            with suppress(PluginError):
                plant = self._parts.backend.snapshot()
            self._unchanged = Unchanged(k, self._bodies, plant, save(self._present.weighed))
            self._rounded = False
        return self._unchanged

    def _take(self, unchanged: Unchanged, bodies: tuple[Attachment, ...]) -> None:
        """Attach the bodies to the plant as it was before the changes of the sample, if that is known."""
        backend = self._parts.backend
        if unchanged.plant is not None and self._rounded:
            external = backend.external.copy()  # which other events may have changed since
            self._load(unchanged.bodies)
            backend.restore(unchanged.plant)
            backend.external[:] = external
            self._rounded = False
        if bodies != unchanged.bodies or self._rounded:
            self._rounded = True
            self._load(bodies)

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

    def _change(self, k: int, bodies: tuple[Attachment, ...]) -> None:
        self._inertial[:] = with_attachments(self._robot, bodies).inertial
