"""Payload: a rigid body that the platform takes, and releases later."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, Field

from cdpr.base.fields import ZERO, Positive, Vector3, unit
from cdpr.base.needs import YES, Needs, of_event
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.mechanics.attachments import Attachment
from cdpr.scenario.events.event import AttachmentSpan, ScenarioEvent, first_sample
from cdpr.scenario.robot_schema import DEFINITE_TOLERANCE, TRIANGLE_TOLERANCE, Inertia, tensor


def _possible(inertia: Inertia) -> Inertia:
    """Return the inertia; raise ValueError unless a rigid body, a thin rod or a point mass can have it."""
    low, middle, high = np.linalg.eigvalsh(np.array(tensor(inertia)))
    moments = f"its principal moments are {low:.6g}, {middle:.6g}, {high:.6g} kg m^2"
    if low < -DEFINITE_TOLERANCE * abs(high):
        raise ValueError(f"no rigid body has this inertia: {moments}, none may be negative")
    if low + middle < high * (1.0 - TRIANGLE_TOLERANCE):
        raise ValueError(f"no rigid body has this inertia: {moments}, the largest exceeds the sum of the two others")
    return inertia


class Payload(ScenarioEvent):
    """Rigid body on the platform for some time. Simultaneous payloads add up.

    It joins with the velocity of the platform: pose and twist of the platform's origin are continuous, and the momentum
    of the payload comes from outside. When it is released, it takes its momentum with it.
    """

    needs: ClassVar[Needs] = of_event(plant_fmu=YES, controller_fmu=YES, backend={"load": True})
    changes_mass: ClassVar[bool] = True

    type: Literal["payload"] = Field(
        default_factory=lambda: "payload",
        description="the platform takes a rigid body at its own velocity, and releases it after the duration",
    )
    duration: Positive | None = Field(
        None,
        description="duration, at least control_step; default: until the end of the run",
        json_schema_extra=unit("s"),
    )
    mass: Positive = Field(description="mass of the payload", json_schema_extra=unit("kg"))
    center: Vector3 = Field(
        ZERO,
        description="its centre of mass from the platform's origin, platform axes",
        json_schema_extra=unit("m"),
    )
    inertia: Annotated[Inertia, AfterValidator(_possible)] = Field(
        (0.0,) * 6,
        description="ixx, iyy, izz, ixy, ixz, iyz about its own centre of mass, platform axes (tensor entries); "
        "default: a point mass",
        json_schema_extra=unit("kg m^2"),
    )
    known: bool = Field(
        False, description="true: controller and nominal robot take its mass, centre and inertia into account"
    )

    log_energy: bool = Field(
        True,
        description="false: the run has no column `load_energy`, and its energy balance is not judged, unless another "
        "payload logs it; so in a saved session whose payloads came live",
    )

    @property
    def logs_energy(self) -> bool:
        """Return whether the run logs its energy."""
        return self.log_energy

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield a problem if it is shorter than a control step."""
        if self.duration is not None and self.duration < step * (1.0 - 1e-9):
            yield "duration", f"must be at least control_step, {exact(step)} (s), got {exact(self.duration)}"

    def attachment(self, step: float) -> AttachmentSpan:
        """Return the body."""
        body = Attachment(self.mass, np.array(self.center), np.array(tensor(self.inertia)), self.known)
        end = math.inf if self.duration is None else float(first_sample(self.time + self.duration, step))
        return AttachmentSpan(first_sample(self.time, step), end, body)

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the payload and its end."""
        end = None
        if self.duration is not None:
            end = min(first_sample(self.time + self.duration, step), samples - 1) * step
        center = ", ".join(f"{value:g}" for value in self.center)
        known = "known" if self.known else "unknown"
        text = f"payload of {self.mass:g} kg at [{center}] m, {known} to the controller"
        yield Event(first_sample(self.time, step) * step, self.type, text, end)
