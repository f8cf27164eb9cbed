"""Event that redirects the motion to a new target."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from cdpr import trajectory
from cdpr.base.fields import INITIAL, Position, Positive, unit
from cdpr.base.needs import Needs, of_event
from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.scenario.events.event import History, ScenarioEvent, first_sample
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.jerk_limited import AngularLimits, Limits, bounds
from cdpr.scenario.orientation import Orientation


class Target(ScenarioEvent):
    """Motion to another pose, from the current state; the pose is then held.

    It is a quintic: position, velocity and acceleration are continuous.
    """

    needs: ClassVar[Needs] = of_event()
    type: Literal["target"] = Field(
        default_factory=lambda: "target",
        description="the desired motion leaves what it was going to do, goes to a pose without a jump in position, "
        "velocity or acceleration, and stays there",
    )
    position: Position = Field(
        INITIAL,
        description="new position of the platform's origin, also if a tool moves; default: the present one",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude there; default: that of the motion at this time")
    duration: Positive | None = Field(
        None, description="time that the move takes; this or limits", json_schema_extra=unit("s")
    )
    limits: Limits | None = Field(
        None, description="limits of the translation: the move is as short as they allow; these or duration"
    )
    angular_limits: AngularLimits | None = Field(
        None, description="limits of the rotation; required with limits where the attitude changes"
    )

    @model_validator(mode="after")
    def _complete(self) -> Target:
        given = self.model_fields_set  # including null, which is reported separately
        if not given & {"position", "orientation"}:
            raise ValueError("position (m), orientation, or both are required")
        if len(given & {"duration", "limits"}) != 1:
            raise ValueError("expected either duration (s) or limits (speed of the motion), not both")
        if "angular_limits" in given and "limits" not in given:
            raise ValueError("angular_limits go with limits, not with duration")
        return self

    def goal(self) -> Posed:
        """Return the target pose."""
        return self

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield a problem if the move is shorter than a control step."""
        if self.duration is not None and self.duration < step * (1.0 - 1e-9):
            text = f"must be at least control_step, {exact(step)} (s), or it is a jump, got {exact(self.duration)}"
            yield "duration", text

    def stay(self, guide: Guide, where: Path) -> None:
        """Report a pose that the guide does not allow."""
        guide.check(where, self)

    def follow(self, history: History) -> Iterator[str]:
        """Yield a problem if the robot is already stopped."""
        if history.stopped is not None:
            yield f"the robot is stopped at {exact(history.stopped)} s: it cannot move afterwards"

    def redirect(self, motion: trajectory.Trajectory, step: float) -> trajectory.Trajectory:
        """Return the motion that is redirected at the first sample."""
        return trajectory.redirected(
            motion,
            first_sample(self.time, step) * step,
            None if self.position is None else np.array(self.position),
            None if self.orientation is None else self.orientation.quaternion(),
            self.duration,
            None if self.limits is None else bounds(self.limits),
            None if self.angular_limits is None else bounds(self.angular_limits),
        )

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the target."""
        parts = []
        if self.position is not None:
            parts.append(f"to {_list(self.position)} m")
        if self.orientation is not None:
            parts.append(f"attitude {_list(self.orientation.quaternion().tolist())} (w, x, y, z)")
        parts.append("within its limits" if self.duration is None else f"within {self.duration:g} s")
        yield Event(first_sample(self.time, step) * step, self.type, f"new target: {', '.join(parts)}")


def _list(values: tuple[float, ...] | list[float]) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"
