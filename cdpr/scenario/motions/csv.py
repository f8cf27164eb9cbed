"""Smooth path through the rows of a CSV file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr

from cdpr import trajectory
from cdpr.base import tolerances
from cdpr.base.fields import INITIAL, NonNegative
from cdpr.base.files import ContentError
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.model.robot import Array
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import RATES, Guide, Posed
from cdpr.scenario.motions.motion import Motion, Place, Report, begins, posed
from cdpr.scenario.motions.table import MAX_BYTES, Table, parse_table
from cdpr.scenario.orientation import Orientation

FILE: Path = ("file",)


class Csv(Motion):
    """Smooth path through the rows of a CSV file; the last row is held.

    Missing rates are chosen as for waypoints: smooth at inner rows, zero at both ends.
    """

    needs: ClassVar[Needs] = of_motion()
    files: ClassVar[tuple[str, ...]] = ("file",)

    type: Literal["csv"] = Field(
        default_factory=lambda: "csv", description="a smooth path through the rows of a CSV file"
    )
    start: NonNegative = begins("time to which the file's times are added")
    file: str = Field(
        min_length=1,
        description="name of the file, relative to this one; its first line names the columns: t (s), x, y, z (m), "
        "and if wanted qw, qx, qy, qz, vx, vy, vz (m/s), wx, wy, wz (rad/s), ax, ay, az (m/s^2), world axes",
    )
    orientation: Orientation = Field(
        INITIAL, description="attitude if the file has no quaternions; default: the initial one"
    )
    sha256: str | None = Field(
        None, pattern="^[0-9a-f]{64}$", description="checksum; if given, the file must still have it"
    )
    _table: Table | None = PrivateAttr(None)

    @property
    def table(self) -> Table:
        """Content of the file; available after loading."""
        assert self._table is not None
        return self._table

    def load(self, report: Report) -> Self | None:
        """Return a copy with its file loaded."""
        content = report.read(FILE, self.file, MAX_BYTES, (".csv",))
        if content is None:
            return None
        try:
            table = parse_table(content)
        except ContentError as error:
            for line, column, text in error.faults:
                report.add_file_problem(FILE, self.file, line, column or 1, text)
            return None
        if self.sha256 not in (None, table.sha256):
            report.add_problem(("sha256",), f"'{report.path(self.file)}' has changed: its checksum is {table.sha256}")
        copy = self.model_copy(update={"sha256": table.sha256})
        copy._table = table
        return copy

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return no poses: they are in the file."""
        return []

    def places(self, initial: Initial) -> Iterator[Place]:
        """Yield the extreme points along each axis."""
        attitude = (self.orientation or initial.orientation).quaternion()
        positions, attitudes = self.table.columns["position"], self.table.get("orientation")
        for row in {*positions.argmin(axis=0).tolist(), *positions.argmax(axis=0).tolist()}:
            yield FILE, positions[row], attitude if attitudes is None else attitudes[row]

    def stay(self, guide: Guide, report: Report) -> None:
        """Report the first point of each kind that violates the guide."""
        if self.orientation is not None:
            guide.attitude(("trajectory", "orientation"), self.orientation)
        table = self.table
        away: list[tuple[str, Array, slice]] = [("position", table.columns["position"] - guide.home, slice(0, 3))]
        attitudes = table.get("orientation")
        if attitudes is not None:
            away.append(("orientation", attitudes[:, 1:], slice(3, 6)))
        for name, part in RATES:
            rates = table.get(name)
            if rates is not None:
                away.append((name, rates, part))
        for name, values, part in away:
            wrong = np.flatnonzero((guide.held[part] & (np.abs(values) > tolerances.HELD)).any(axis=1))
            if len(wrong):
                text = f"{name.replace('_', ' ')}: {guide.free}; see also {len(wrong) - 1} points more"
                report.add_file_problem(FILE, self.file, table.lines[wrong[0]], 1, text)

    def complete(self, initial: Initial) -> Self:
        """Return a copy with a missing attitude set to the initial one."""
        return posed(self, initial)

    def span(self) -> tuple[float | None, float | None]:
        """Return the start and end times, s."""
        first, last = (self.start + float(self.table.times[k]) for k in (0, -1))
        return first, last

    def check_rest(self, k: int, text: str, report: Report) -> None:
        """Report a first or last point that is not at rest."""
        for name in ("velocity", "angular_velocity"):
            rates = self.table.get(name)
            if rates is not None and rates[k].any():
                report.add_file_problem(FILE, self.file, self.table.lines[k], 1, f"{name.replace('_', ' ')}: {text}")

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        table = self.table
        attitudes = table.get("orientation")
        if attitudes is None:
            attitudes = np.tile(self.orientation.quaternion(), (len(table.times), 1))
        rates = [table.get(name) for name in ("velocity", "angular_velocity", "acceleration")]
        return trajectory.interpolate(self.start + table.times, table.columns["position"], attitudes, *rates)
