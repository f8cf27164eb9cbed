"""Circular and helical motions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from cdpr import trajectory
from cdpr.base import tolerances
from cdpr.base.fields import INITIAL, NonNegative, Number, Position, Positive, Vector3, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Place, Report, begins, pose, posed
from cdpr.scenario.orientation import Orientation

MAX_TURNS = 1000
ON_THE_WAY = 12  # places per turn that are checked


class Circle(Motion):
    """Circle or arc from rest to rest; its end is held."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["circle"] = Field(default_factory=lambda: "circle", description="round a centre, from rest to rest")
    start: NonNegative = begins()
    duration: Positive = Field(description="duration of all turns", json_schema_extra=unit("s"))
    position: Position = Field(
        INITIAL,
        description="start, which determines the radius; default: the initial position",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude at the start; default: the initial one")
    center: Position = Field(description="centre, in the plane of the beginning", json_schema_extra=unit("m"))
    normal: Vector3 = Field((0.0, 0.0, 1.0), description="direction of the axis, of any length")
    turns: float = Field(
        1.0,
        ge=-MAX_TURNS,
        le=MAX_TURNS,
        description="number of turns, also fractional; right-handed about the normal, negative in the other direction",
    )
    turning: bool = Field(
        False, description="true if the platform rotates with the path; false if it keeps its attitude"
    )

    def climb(self) -> float:
        """Return the climb along the normal per turn, m."""
        return 0.0

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return the start pose."""
        return [((), self)]

    def places(self, initial: Initial) -> Iterator[Place]:
        """Yield the start and some places along the path."""
        yield from super().places(initial)
        whole = self.complete(initial)
        normal = np.array(self.normal) / (float(np.linalg.norm(self.normal)) or 1.0)
        arm = np.array(whole.position) - self.center
        for angle in np.linspace(0.0, 2.0 * np.pi * self.turns, 1 + max(1, round(ON_THE_WAY * abs(self.turns)))):
            turned = np.cos(angle) * arm + np.sin(angle) * np.cross(normal, arm)
            climbed = 0.5 * angle / np.pi * self.climb() * normal
            yield ("center",), self.center + turned + climbed, whole.orientation.quaternion()

    def stay(self, guide: Guide, report: Report) -> None:
        """Report violations of the guide along the path; its plane determines them."""
        if guide.held[:3].sum() > 1:
            text = "so no circle is possible; choose quintic, waypoints or jerk_limited"
            report.add_problem(("type",), f"{guide.free}, {text}")
            return
        normal = np.array(self.normal)
        length = float(np.linalg.norm(normal))
        if length == 0.0:
            return
        normal /= length
        if (guide.held[:3] & (np.sqrt(np.maximum(1.0 - normal**2, 0.0)) > tolerances.HELD)).any():
            axes = ", ".join("xyz"[i] for i in np.flatnonzero(guide.held[:3]))
            report.add_problem(("normal",), f"{guide.free}, so the circle must not leave its plane: normal to {axes}")
        if (guide.held[:3] & (np.abs(self.climb() * normal) > tolerances.HELD)).any():
            report.add_problem(("pitch",), f"{guide.free}, so the path must not climb along the normal")
        if self.turning and (guide.held[3:] & (np.abs(normal) > tolerances.HELD)).any():
            report.add_problem(("turning",), f"{guide.free}, so the platform cannot turn about the normal")

    def complete(self, initial: Initial) -> Self:
        """Return a copy with missing values set to the initial pose."""
        return posed(self, initial)

    def check_completed(self, report: Report) -> None:
        """Report an invalid circle."""
        if self.turns == 0.0:
            report.add_problem(("turns",), "must not be 0; to stay, use type: hold")
        length = float(np.linalg.norm(self.normal))
        if length < tolerances.LENGTH:
            text = f"must not be zero; that of a level circle is [0, 0, 1], got {exact(length)}"
            report.add_problem(("normal",), text)
            return
        normal = np.array(self.normal) / length
        arm = np.array(self.position) - self.center
        climb = float(arm @ normal)
        if np.linalg.norm(arm - climb * normal) < tolerances.LENGTH:
            report.add_problem(("center",), "the circle has no radius: its beginning lies on its axis")
        elif abs(climb) > tolerances.LENGTH:
            near = ", ".join(f"{value:.9g}" for value in self.center + climb * normal)
            text = f"lies {abs(climb):.6g} m out of the plane of the circle's beginning; nearest in it: [{near}]"
            report.add_problem(("center",), text)

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        normal = np.array(self.normal)
        return trajectory.circle(
            self.start,
            self.duration,
            *pose(self),
            np.array(self.center),
            normal / np.linalg.norm(normal),
            self.turns,
            pitch=self.climb(),
            turning=self.turning,
        )


class Helix(Circle):
    """Circle that climbs along its axis."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["helix"] = Field(
        default_factory=lambda: "helix", description="round an axis and along it, from rest to rest"
    )  # type: ignore[assignment]
    pitch: Number = Field(
        description="way along the normal per turn; backwards for negative turns", json_schema_extra=unit("m")
    )

    def climb(self) -> float:
        """Return the climb along the normal per turn, m."""
        return self.pitch
