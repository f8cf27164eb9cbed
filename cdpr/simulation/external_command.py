"""External wrenches and commands of cables, which replace the answers of controller or solver."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.base.fields import MAX_UNWOUND
from cdpr.cables import commands_of
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.controller import Output, listed, stage_of_output
from cdpr.scenario.events import end_of_commands
from cdpr.scenario.events.commands import Kind
from cdpr.simulation.parts import Parts
from cdpr.simulation.pipeline import Pipeline
from cdpr.simulation.record import Record
from cdpr.simulation.winding import Winding
from cdpr.tension.command import CommandStage
from cdpr.tension.operations import Operation
from cdpr.tension.stage import TensionStage
from cdpr.tension.winch_command import WinchStage

Stage = TensionStage | CommandStage

GIVEN = b"\0"  # position of the caller's values among the arrays of `record_command`


class ClosedLoop(Protocol):
    """Loop with an external command in place of its controller or solver."""

    parts: Parts
    pipeline: Pipeline
    stage: Stage
    advancing: list[Operation]
    row: Array
    tension: Array
    winding: Winding

    def stage_of(self, output: Output) -> Stage:
        """Make a stage for such an output."""

    def written(self, stage: Stage) -> Array:
        """Return the input of the stage."""

    def through(self, stage: Stage) -> list[Operation]:
        """Return the operations that complete a sample by the stage."""


class Command:
    """External command.

    Attributes:
        kind: name of the command.
        values: (6,) wrench in N and N m, or (m,) commands in N, m or m/s; the pipeline reads them here.
        stage: distribution of the wrench, or check of the tensions.
        pipeline: steps in which they replace the answer.
        take: operation that checks and copies values, and records them for a number of `steps`.
        cables: cables whose command is a length, by number and name.
    """

    __slots__ = (
        "_record",
        "_steps",
        "_used",
        "_view",
        "cables",
        "kind",
        "pipeline",
        "stage",
        "steps",
        "take",
        "values",
    )

    def __init__(
        self, kind: Kind, values: Array, stage: Stage, pipeline: Pipeline, record: Record, cables: dict[int, str]
    ) -> None:
        self.cables, self._view = cables, values.data  # whose list is fast to make
        self.kind, self.values, self.stage, self.pipeline = kind, values, stage, pipeline
        self._record, self._steps, self.steps = record, np.ones(1, dtype=np.int64), 1
        table, used = record.table(kind, len(values))
        self._used = used
        given = {"given": np.zeros_like(values), "values": values}
        live = {"standing": pipeline.standing[0], "steps": self._steps}
        self.take = bind("record_command", **given, record=table, used=used, **live).on

    def last(self, steps: int) -> None:
        """Record another number of steps from now on."""
        self.steps = self._steps[0] = steps

    def take_checked(self, values: ArrayLike) -> None:
        """Accept values of any type.

        Raises:
            CdprError: if they are not finite numbers of the right shape.
        """
        found = checked(values, self.values.shape, self.kind, finite=True)
        if self.take(GIVEN, found):
            self._record.complete()
            self.take(GIVEN, found)

    def check_lengths(self) -> None:
        """Raise CdprError, and omit the accepted command from the record, if one of its lengths is out of range."""
        try:
            check_lengths(self.kind, self._view.tolist(), self.cables)
        except CdprError:
            self._used[0] -= 1
            raise


def check_lengths(kind: Kind, given: Sequence[float], cables: dict[int, str]) -> None:
    """Raise CdprError if a command of a length is out of range; `cables` are those, by number and name."""
    lengths = given if len(cables) == len(given) else [given[i] for i in cables]
    if not lengths or (min(lengths) > 0.0 and max(lengths) <= MAX_UNWOUND):
        return
    name, value = next((name, given[i]) for i, name in cables.items() if not 0.0 < given[i] <= MAX_UNWOUND)
    raise CdprError(f"{kind}: cable '{name}': expected more than 0 and at most {MAX_UNWOUND:g} m, got {value:g}")


class ExternalCommands:
    """Pipelines of a loop for external commands; each is made at its first use.

    Attributes:
        end: first sample at which they do not replace answers, because the robot stops; infinity without a stop.
    """

    def __init__(self, loop: ClosedLoop, record: Record) -> None:
        self._loop, self._record = loop, record
        self.end = end_of_commands(loop.parts.events, loop.parts.control_step)
        self._commands: dict[tuple[Kind, bool], Command] = {}
        self._last: Command | None = None  # for commands after the first sample

    @property
    def pipelines(self) -> Iterator[Pipeline]:
        """Return all pipelines made so far."""
        return (command.pipeline for command in self._commands.values())

    def give(self, kind: Kind, values: ArrayLike, steps: int) -> Pipeline:
        """Return the pipeline with this wrench (6,) or these commands (m,), copied and recorded for `steps`.

        Raises:
            CdprError: if the values are not finite numbers of that shape, or the winches do not take them, or a length
                is out of range.
        """
        command = self._last
        if command is None or command.kind != kind:
            command = self.command(kind)
        if command.steps != steps:
            command.last(steps)
        try:
            taken = not command.take(GIVEN, values)
        except (TypeError, ValueError):  # another type, shape or memory layout
            taken = False
        if not taken:
            command.take_checked(values)
        if command.cables:
            command.check_lengths()
        return command.pipeline

    def steps_left(self, count: int, last: int) -> float:
        """Return the number of steps from sample `count` in which commands can replace the answers.

        The step to sample `last` also decides that sample.
        """
        return math.inf if self.end > last else max(self.end - count - (self.end == last), 0)

    def check_stop(self, count: int, n: int, last: int, where: str = "step") -> None:
        """Raise CdprError if the robot stops within n steps from sample `count`."""
        left = self.steps_left(count, last)
        if n > left:
            remedy = f"take {left} steps with them and then others without" if left else "omit them"
            raise CdprError(
                f"{where}: the robot stops at {self.end * self._loop.parts.control_step:g} s, and from then on "
                f"wrenches and commands cannot replace the answers of controller and solver: {remedy}"
            )

    def command(self, kind: Kind) -> Command:
        """Return the command for the present sample."""
        loop, first = self._loop, self._loop.pipeline.count == 0
        found = self._commands.get((kind, first))
        if found is None:
            found = self._commands[kind, first] = self._make(kind, first)
        if first and found.stage is not loop.stage:
            found.stage.forget()
        self._last = None if first else found
        return found

    def _make(self, kind: Kind, first: bool) -> Command:
        """Return a command for the first sample or for later ones.

        Its own stage takes the previous tensions as its last answer, and the loop's stage afterwards takes those of the
        command.
        """
        loop, stage = self._loop, self._stage(kind)
        if first and isinstance(stage, WinchStage) and stage is not loop.stage:
            loop.winding.hold(loop.stage_of("wrench"))
        out = loop.written(stage)
        values = np.zeros_like(out)
        deciding = [Operation("command", bind("copy", source=values, target=out)), *loop.through(stage)]
        if stage is not loop.stage:
            before = [] if first else self._following(stage)
            deciding = [*before, *deciding, *self._following(loop.stage)]
        pipeline = Pipeline(deciding, loop.advancing, loop.row, loop.parts.control_step, loop.pipeline)
        robot = loop.parts.robot
        takes = zip(robot.cables, commands_of(robot), strict=True) if kind in ("length", "command") else ()
        lengths = {i: cable.name for i, (cable, takes_) in enumerate(takes) if takes_ == "length"}
        return Command(kind, values, stage, pipeline, self._record, lengths)

    def _stage(self, kind: Kind) -> Stage:
        takes = commands_of(self._loop.parts.robot)
        output = stage_of_output(kind, takes)
        if output is None:
            raise CdprError(
                f"{kind}: the winches of this robot take {listed(takes)}: give a wrench, tensions, or `command`, "
                "which is the quantity that each winch takes"
            )
        if output == self._loop.parts.output:
            return self._loop.stage
        stages = [command.stage for command in self._commands.values() if command.kind == kind]
        return stages[0] if stages else self._loop.stage_of(output)

    def _following(self, stage: Stage) -> list[Operation]:
        """Make a stage take the present tensions, chosen by another one, as its last answer."""
        return [Operation("command", bind("copy", source=self._loop.tension, target=answer)) for answer in stage.arrays]
