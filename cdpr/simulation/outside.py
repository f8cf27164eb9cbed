"""Programs in which wrenches or commands from outside decide in place of the controller."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.controller import Output
from cdpr.simulation.parts import Parts
from cdpr.simulation.program import Program
from cdpr.tension.acts import Act
from cdpr.tension.command import CommandStage
from cdpr.tension.stage import TensionStage

Stage = TensionStage | CommandStage


class ClosedLoop(Protocol):
    """The loop in whose steps they decide, with what its program is made of."""

    parts: Parts
    program: Program
    stage: Stage
    advancing: list[Act]
    row: Array
    tension: Array

    @property
    def count(self) -> int:
        """Number of complete samples."""

    def stage_of(self, output: Output) -> Stage:
        """Make a stage for such an output."""

    def written(self, stage: Stage) -> Array:
        """Return where the stage reads its input."""

    def through(self, stage: Stage) -> list[Act]:
        """Return the acts that complete a sample by the stage."""


class Outside:
    """Programs beside that of a loop, made when they are first needed."""

    def __init__(self, loop: ClosedLoop) -> None:
        self._loop = loop
        self._stages: dict[Output, Stage] = {}
        self._made: dict[tuple[Output, bool], tuple[Array, Program]] = {}

    @property
    def programs(self) -> Iterator[Program]:
        """Those that are made."""
        return (program for _, program in self._made.values())

    def give(self, output: Output, values: Array) -> Program:
        """Return the program in which these values decide, (6,) or (m,); they are copied."""
        first = self._loop.count == 0
        made = self._made.get((output, first))
        if made is None:
            made = self._made[output, first] = self._make(output, first)
        given, program = made
        given[:] = values
        if first and output != self._loop.parts.output:
            self._stages[output].forget()
        return program

    def _make(self, output: Output, first: bool) -> tuple[Array, Program]:
        """Return where to write what is given, and the program for the first sample or for later ones.

        A stage of its own takes the tensions of the sample before for its answer, and the loop's stage then takes its.
        """
        loop = self._loop
        if output not in self._stages:
            self._stages[output] = loop.stage if output == loop.parts.output else loop.stage_of(output)
        stage = self._stages[output]
        out = loop.written(stage)
        given = np.zeros_like(out)
        deciding = [Act("command", bind("copy", source=given, target=out)), *loop.through(stage)]
        if stage is not loop.stage:
            before = [] if first else self._following(stage)
            deciding = [*before, *deciding, *self._following(loop.stage)]
        return given, Program(deciding, loop.advancing, loop.row, loop.parts.control_step, loop.program)

    def _following(self, stage: Stage) -> list[Act]:
        """Let a stage take the present tensions, which another one chose, for its answer of the step before."""
        return [Act("command", bind("copy", source=self._loop.tension, target=answer)) for answer in stage.arrays]
