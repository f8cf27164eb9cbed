"""What every desired motion of a scenario is: a section, its checks, and the trajectory that it describes."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from pydantic import Field

from cdpr import trajectory
from cdpr.fields import INITIAL, ZERO, Kind, Name, Position, Section, unit
from cdpr.model.robot import Array
from cdpr.problems import Path
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed, Rated
from cdpr.scenario.orientation import Orientation

S = TypeVar("S", bound=Section)

Place = tuple[Path, Array, Array]  # where it is said; position (3,), m, and quaternion (4,) of the platform, world


class Report(Protocol):
    """Takes what is wrong with a motion; paths are below `trajectory`."""

    def say(self, path: Path, text: str) -> None:
        """Report a problem of the value at `path`."""

    def path(self, file: str) -> str:
        """Return the path of a file that is named relative to the scenario."""

    def say_of_file(self, path: Path, file: str, line: int, column: int, text: str) -> None:
        """Report a problem of the file that is named at `path`; line and column count from 1."""

    def read(self, path: Path, file: str, size: int, endings: tuple[str, ...]) -> bytes | None:
        """Return what the file that is named at `path` holds, of `size` bytes at most; None where it cannot be read."""


class Motion(Kind):
    """A desired motion, of the platform's origin or, with `tool`, of one of its tools; the attitude is the platform's.

    Attributes:
        files: keys that name files.
    """

    files: ClassVar[tuple[str, ...]] = ()

    tool: Name | None = Field(
        None, description="the one of `platform.tools` that moves as this says; the platform's origin unless said"
    )

    def begins(self, initial: Initial, tools: Mapping[str, Sequence[float] | Array]) -> Initial:
        """Return the initial state of what moves: of the tool, (3,), m, where one does, else of the origin."""
        return initial if self.tool is None else initial.of_tool(np.array(tools[self.tool]))

    @abstractmethod
    def poses(self) -> list[tuple[Path, Posed]]:
        """Return the poses that the section itself holds, in the order of time, and their paths within it."""

    def places(self, initial: Initial) -> Iterator[Place]:
        """Yield where it goes, also on the way and by its files, as it was given; what is left out goes nowhere new."""
        start = initial.orientation.quaternion()
        for path, point in self.poses():
            if point.position is not None:
                attitude = start if point.orientation is None else point.orientation.quaternion()
                yield (*path, "position"), np.array(point.position), attitude

    @abstractmethod
    def stay(self, guide: Guide, report: Report) -> None:
        """Report what leaves the guide beyond these poses: between them, or in a file."""

    @abstractmethod
    def complete(self, initial: Initial) -> Self:
        """Return a copy in which what was left out is filled in, such as the initial pose."""

    @abstractmethod
    def make(self) -> trajectory.Trajectory:
        """Return the trajectory of the completed motion."""

    def load(self, report: Report) -> Self | None:
        """Return the motion with what its files hold; None where they are wrong, which is reported."""
        return self

    def check(self, report: Report) -> None:
        """Report what is wrong with the motion as it is given."""

    def check_completed(self, report: Report) -> None:
        """Report what is wrong with the completed motion."""

    def remarks(self, initial: Initial) -> Iterator[tuple[Path, str]]:
        """Yield what of the motion, as it was given, is allowed and seldom meant."""
        yield from ()

    def span(self) -> tuple[float | None, float | None]:
        """Return the times at which it begins and ends, s; None where it is at rest there by itself."""
        return None, None

    def ends(self) -> float | None:
        """Return when the completed motion ends, s; None where it never does, or only its trajectory knows."""
        start, duration = getattr(self, "start", None), getattr(self, "duration", None)
        return self.span()[1] if start is None or duration is None else float(start + duration)

    def check_rest(self, k: int, text: str, report: Report) -> None:
        """Report where it is not at rest in its first pose, k = 0, or its last one, k = -1."""
        path, point = self.poses()[k]
        for name in ("velocity", "angular_velocity"):
            if any(getattr(point, name) or ZERO):
                report.say((*path, name), text)


class Pose(Section):
    """Position and attitude, world axes; the initial ones unless said."""

    position: Position = Field(
        INITIAL,
        description="position of the platform's origin; the initial one unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")


def begins(text: str = "time at which the motion begins; until then its first pose is held") -> Any:
    """Return the field that says when a motion begins."""
    return Field(0.0, description=text, json_schema_extra=unit("s"))


def posed(section: S, initial: Initial) -> S:
    """Return the section with the initial position and attitude where it has none."""
    missing = [name for name in ("position", "orientation") if getattr(section, name, ZERO) is None]
    return section.model_copy(update={name: getattr(initial, name) for name in missing})


def pose(section: Posed) -> tuple[Array, Array]:
    """Return position (3,), m, and quaternion (4,)."""
    return np.array(section.position), section.orientation.quaternion()


def knot(time: float, section: Rated) -> trajectory.Knot:
    """Return what a spline passes at a time, s."""

    def given(values: tuple[float, ...] | None) -> Array | None:
        return None if values is None else np.array(values)

    return trajectory.Knot(
        time,
        *pose(section),
        given(section.velocity),
        given(section.angular_velocity),
        given(section.acceleration),
        given(section.angular_acceleration),
    )
