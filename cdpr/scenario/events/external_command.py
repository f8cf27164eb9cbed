"""Playback of recorded external commands."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, Literal, Self

from pydantic import Field, PrivateAttr

from cdpr.base.fields import NonNegative, unit
from cdpr.base.files import ContentError
from cdpr.base.needs import Needs, of_event
from cdpr.log.event import Event
from cdpr.scenario.events.commands import MAX_BYTES, Span, parsed
from cdpr.scenario.events.event import History, ScenarioEvent
from cdpr.scenario.motions.motion import Report


class ExternalCommand(ScenarioEvent):
    """Wrenches or commands of cables from a file that replace the output of controller or solver."""

    needs: ClassVar[Needs] = of_event()
    files: ClassVar[tuple[str, ...]] = ("file",)
    type: Literal["outside"] = Field(
        default_factory=lambda: "outside",
        description="wrenches or commands of cables from a file, in place of the answers of controller or solver",
    )
    time: NonNegative = Field(0.0, description="time to which the file's times are added", json_schema_extra=unit("s"))
    file: str = Field(
        min_length=1,
        description="name of the file, relative to this one, as cdpr.Simulation.save writes it: t, until (s), "
        "fx to mz (N, N m) and the command of each cable: its tension (N), or what `quantity` names",
    )
    sha256: str | None = Field(
        None, pattern="^[0-9a-f]{64}$", description="checksum; if given, the file must still have it"
    )
    _content: tuple[tuple[str, ...], tuple[Span, ...]] = PrivateAttr(((), ()))

    def load(self, report: Report) -> Self | None:
        """Return a copy with its file loaded."""
        content = report.read(("file",), self.file, MAX_BYTES, (".csv",))
        if content is None:
            return None
        try:
            spans = parsed(content)
        except ContentError as error:
            for line, column, text in error.faults:
                report.add_file_problem(("file",), self.file, line, column or 1, text)
            return None
        sha256 = hashlib.sha256(content).hexdigest()
        if self.sha256 not in (None, sha256):
            report.add_problem(("sha256",), f"'{report.path(self.file)}' has changed: its checksum is {sha256}")
        copy = self.model_copy(update={"sha256": sha256})
        copy._content = spans
        return copy

    def follow(self, history: History) -> Iterator[str]:
        """Yield a problem if the file belongs to another robot."""
        cables = self._content[0]
        if history.cables and cables != tuple(history.cables):
            yield f"'{self.file}' is of a robot with the cables {', '.join(cables)}, not {', '.join(history.cables)}"

    def commands(self) -> Sequence[Span]:
        """Return the content of the file."""
        return [Span(each.kind, self.time + each.start, self.time + each.end, each.values) for each in self._content[1]]

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield nothing: external commands are logged for the whole run, whether from a file or not."""
        return iter(())
