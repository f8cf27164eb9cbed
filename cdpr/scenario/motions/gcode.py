"""Motion along the path of a G-code file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr

from cdpr import trajectory
from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.fields import INITIAL, ZERO, NonNegative, Position, Positive, Vector3, unit
from cdpr.base.files import ContentError, CpuBudget, UnreadableError
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.gcode import follow
from cdpr.gcode import path as gcode_path
from cdpr.gcode.program import parse_program
from cdpr.gcode.steps import Program
from cdpr.gcode.tables import IGNORABLE
from cdpr.gcode.words import DIVIDE, MAX_BYTES
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.jerk_limited import Limits, bounds
from cdpr.scenario.motions.motion import Motion, Place, Report, begins
from cdpr.scenario.orientation import UPRIGHT, Orientation

FILE: Path = ("file",)
PLANNED = 60.0  # s of CPU time for reading and planning a program: 100 000 arcs may take 20 s on a busy machine

WordName = Annotated[str, Field(pattern=f"^({IGNORABLE})$")]


class Gcode(Motion):
    """Motion along the lines and arcs of a G-code file, from the initial position, with constant attitude."""

    needs: ClassVar[Needs] = of_motion()
    files: ClassVar[tuple[str, ...]] = ("file",)

    type: Literal["gcode"] = Field(
        default_factory=lambda: "gcode", description="along the lines and arcs of a G-code file"
    )
    start: NonNegative = begins()
    file: str = Field(
        min_length=1,
        description="name of the file, relative to this one, with G0, G1, G2, G3, G4 and related words",
    )
    dialect: Literal["linuxcnc", "reprapfirmware"] = Field(
        "linuxcnc",
        description="dialect: for linuxcnc G0 is as fast as the limits allow and G4 P is in s, for "
        "reprapfirmware G0 is G1 and G4 P is in ms",
    )
    units: Literal["mm", "inch", "m"] = Field("mm", description="of the file's lengths until a G20 or G21")
    origin: Position = Field(ZERO, description="origin of the file's coordinates, world", json_schema_extra=unit("m"))
    axes: Orientation = Field(UPRIGHT, description="attitude of the file's axes in the world")
    scale: Positive = Field(1.0, description="factor of the file's lengths, its feeds apart")
    limits: Limits = Field(description="limits of the translation; a feed beyond `velocity` is kept at it")
    tolerance: NonNegative = Field(
        0.0,
        description="allowed deviation from lines and corners to pass without a stop, where there is no G61 or G64 P; "
        "0 stops at each",
        json_schema_extra=unit("m"),
    )
    ignore: list[WordName] = Field(
        [],
        description="words to skip as if without motion, such as G28, A or EXCLUDE_OBJECT_START; a G word with the "
        "coordinates of its line, a command with its whole line",
    )
    sha256: str | None = Field(
        None, pattern="^[0-9a-f]{64}$", description="checksum; if given, the file must still have it"
    )
    _program: Program | None = PrivateAttr(None)
    _initial: Initial = PrivateAttr(INITIAL)

    @property
    def program(self) -> Program:
        """Content of the file; available after loading."""
        assert self._program is not None
        return self._program

    def load(self, report: Report) -> Self | None:
        """Return a copy with its file loaded."""
        content = report.read(FILE, self.file, MAX_BYTES, (".gcode", ".ngc", ".nc", ".g"))
        if content is None:
            return None
        try:
            program = parse_program(content, self.dialect, self.units, tuple(self.ignore))
        except ContentError as error:
            self._report(error, report)
            return None
        if self.sha256 not in (None, program.sha256):
            report.add_problem(("sha256",), f"'{report.path(self.file)}' has changed: its checksum is {program.sha256}")
        copy = self.model_copy(update={"sha256": program.sha256})
        copy._program = program
        return copy

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return no poses: they are in the file."""
        return []

    def places(self, initial: Initial) -> Iterator[Place]:
        """Yield the extreme points along each axis."""
        course = self._path(initial.position).course
        if course is not None:
            for point in gcode_path.farthest(course):
                yield FILE, point, initial.orientation.quaternion()

    def stay(self, guide: Guide, report: Report) -> None:
        """Report the first piece that violates the guide."""
        try:
            path = self._path((guide.home[0], guide.home[1], guide.home[2]))
        except ContentError:
            return  # reported by `check_completed`
        if path.course is None or not guide.held[:3].any():
            return
        pieces = path.course.pieces
        every = np.arange(len(pieces))
        for share in (1.0, 0.25, 0.5, 0.75):
            away = np.abs(pieces.at(every, share * pieces.length)[0] - guide.home) > tolerances.HELD
            wrong = np.flatnonzero((guide.held[:3] & away).any(axis=1))
            if len(wrong):
                more = f", nor do {len(wrong) - 1} moves more stay there" if len(wrong) > 1 else ""
                text = f"{guide.free}{more}; 'axes' turns the file's axes, and 'origin' shifts them"
                report.add_file_problem(FILE, self.file, int(path.lines[wrong[0]]), 1, text)
                return

    def complete(self, initial: Initial) -> Self:
        """Return a copy that starts at the initial pose."""
        copy = self.model_copy()
        copy._initial = initial
        return copy

    def check_completed(self, report: Report) -> None:
        """Report invalid moves: inconsistent arcs and positions that are too far away."""
        try:
            path = self._path(self._initial.position)
        except ContentError as error:
            self._report(error, report)
            return
        if path.course is None:
            report.add_problem(FILE, "it contains no move from the initial position; to stay, use type: hold")

    def ends(self) -> float:
        """Return the end time, s, which depends on the limits."""
        return self.make().end

    def remarks(self, initial: Initial) -> Iterator[tuple[Path, str]]:
        """Yield remarks on skipped words, and on feeds above the limits."""
        if self.program.passed_over:
            yield FILE, f"skipped, as if without motion: {', '.join(self.program.passed_over)}"
        path = self._path(initial.position)
        if path.course is None:
            return
        feeds = np.where(np.isfinite(path.course.speed), path.course.speed, 0.0)
        fastest = int(feeds.argmax())
        if feeds[fastest] > self.limits.velocity * (1.0 + tolerances.TIME):
            limit = f"this limit, {self.limits.velocity:.6g} m/s"
            where = f"line {path.lines[fastest]} of {self.file}"
            text = f"feeds above {limit}, are reduced to it; the fastest is {feeds[fastest]:.6g} m/s in {where}"
            yield ("limits", "velocity"), text

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory.

        Raises:
            CdprError: if planning takes too much CPU time or too many segments.
        """
        path = self._path(self._initial.position)
        attitude = self._initial.orientation.quaternion()
        if path.course is None:
            return trajectory.hold(np.array(self._initial.position), attitude)
        budget = CpuBudget(self.file, DIVIDE, path.spent, PLANNED)
        try:
            return follow(self.start + path.delay, path.course, bounds(self.limits), attitude, budget.check)
        except UnreadableError as error:
            raise CdprError(f"trajectory.file: {error}") from None

    def _path(self, begin: Vector3) -> gcode_path.Path:
        placing = gcode_path.Placing(self.origin, tuple(self.axes.quaternion().tolist()), self.scale)
        return gcode_path.build_path(self.program, placing, begin, self.tolerance)

    def _report(self, error: ContentError, report: Report) -> None:
        for line, column, text in error.faults:
            report.add_file_problem(FILE, self.file, line, column or 1, text)
