"""Base classes of desired motions: section, checks and trajectory."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import INITIAL, ZERO, Kind, Name, Position, Section, unit
from cdpr.base.problems import Path
from cdpr.model.robot import Array
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed, Rated
from cdpr.scenario.orientation import Orientation

S = TypeVar("S", bound=Section)

Place = tuple[Path, Array, Array]  # path of the value; position (3,), m, and quaternion (4,) of the platform, world


class Report(Protocol):
    """Receiver of a motion's problems; paths are relative to `trajectory`."""

    def add_problem(self, path: Path, text: str) -> None:
        """Report a problem of the value at `path`."""

    def path(self, file: str) -> str:
        """Return the path of a file, relative to the scenario."""

    def add_file_problem(self, path: Path, file: str, line: int, column: int, text: str) -> None:
        """Report a problem in the file referenced at `path`; line and column start at 1."""

    def read(self, path: Path, file: str, size: int, endings: tuple[str, ...]) -> bytes | None:
        """Return the content of the file referenced at `path`, at most `size` bytes; None if it is unreadable."""


class Motion(Kind):
    """Desired motion of the platform's origin or, with `tool`, of a tool; attitudes are the platform's.

    Attributes:
        files: keys that are file names.
    """

    files: ClassVar[tuple[str, ...]] = ()

    tool: Name | None = Field(
        None, description="point among `platform.tools` that follows the motion; default: the platform's origin"
    )

    def begins(self, initial: Initial, tools: Mapping[str, Sequence[float] | Array]) -> Initial:
        """Return the initial state of the moved point: a tool at (3,), m, or the origin."""
        return initial if self.tool is None else initial.of_tool(np.array(tools[self.tool]))

    @abstractmethod
    def poses(self) -> list[tuple[Path, Posed]]:
        """Return the poses in the section with their paths, in order of time."""

    def places(self, initial: Initial) -> Iterator[Place]:
        """Yield the target positions as given, including those along the path and in files; skip omitted ones."""
        start = initial.orientation.quaternion()
        for path, point in self.poses():
            if point.position is not None:
                attitude = start if point.orientation is None else point.orientation.quaternion()
                yield (*path, "position"), np.array(point.position), attitude

    @abstractmethod
    def stay(self, guide: Guide, report: Report) -> None:
        """Report violations of the guide between these poses, or in a file."""

    @abstractmethod
    def complete(self, initial: Initial) -> Self:
        """Return a copy with missing values filled in, such as the initial pose."""

    @abstractmethod
    def make(self) -> trajectory.Trajectory:
        """Return the trajectory of the completed motion."""

    def load(self, report: Report) -> Self | None:
        """Return the motion with its files loaded; None if they are invalid, which is reported."""
        return self

    def check(self, report: Report) -> None:
        """Report problems of the motion as given."""

    def check_completed(self, report: Report) -> None:
        """Report problems of the completed motion."""

    def remarks(self, initial: Initial) -> Iterator[tuple[Path, str]]:
        """Yield remarks on values that are allowed but probably not intended."""
        yield from ()

    def span(self) -> tuple[float | None, float | None]:
        """Return the start and end times, s; None where the motion is at rest by itself."""
        return None, None

    def ends(self) -> float | None:
        """Return the end time of the completed motion, s; None if it never ends, or only the trajectory knows."""
        start, duration = getattr(self, "start", None), getattr(self, "duration", None)
        return self.span()[1] if start is None or duration is None else float(start + duration)

    def check_rest(self, k: int, text: str, report: Report) -> None:
        """Report a first pose (k = 0) or last pose (k = -1) that is not at rest."""
        path, point = self.poses()[k]
        for name in ("velocity", "angular_velocity"):
            if any(getattr(point, name) or ZERO):
                report.add_problem((*path, name), text)


class Pose(Section):
    """Position and attitude, world axes; default: the initial ones."""

    position: Position = Field(
        INITIAL,
        description="position of the platform's origin; default: the initial one",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; default: the initial one")


def begins(text: str = "time at which the motion begins; until then its first pose is held") -> Any:
    """Return the field for the start time of a motion."""
    return Field(0.0, description=text, json_schema_extra=unit("s"))


def posed(section: S, initial: Initial) -> S:
    """Return the section with missing position and attitude set to the initial ones."""
    missing = [name for name in ("position", "orientation") if getattr(section, name, ZERO) is None]
    return section.model_copy(update={name: getattr(initial, name) for name in missing})


def pose(section: Posed) -> tuple[Array, Array]:
    """Return position (3,), m, and quaternion (4,)."""
    return np.array(section.position), section.orientation.quaternion()


def knot(time: float, section: Rated) -> trajectory.Knot:
    """Return the knot of a spline at a time, s."""

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
