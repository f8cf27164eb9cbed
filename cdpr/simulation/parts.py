"""Parts of a closed loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cdpr.base.column import Column
from cdpr.base.columns import GROUPS, LATER
from cdpr.model import Robot
from cdpr.model.shapes import Obstacle
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.controller import Output
from cdpr.plugins.info import Role
from cdpr.scenario.events import ScenarioEvent
from cdpr.simulation.loop_part import LoopPart, perceived_differs
from cdpr.simulation.settings import Settings
from cdpr.tension.policy import Policy
from cdpr.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts of a closed loop."""

    robot: Robot
    controlled_robot: Robot  # nominal robot of the distribution: its dof are the directions to balance
    planned: Trajectory  # desired motion without the effect of events
    trajectory: Trajectory
    controller: Controller
    solver: TensionSolver
    solver_name: str
    respects_bounds: bool
    policy: Policy
    backend: Backend
    control_step: float  # s
    substeps: int  # physics steps in a control step
    output: Output = "wrench"  # output of the controller
    events: tuple[ScenarioEvent, ...] = ()  # events of the run
    limits: Literal["warn", "stop"] = "warn"  # reaction to a cable that exceeds its length or speed_max
    columns: tuple[Column, ...] = LATER  # additional columns of a row, after `cdpr.base.columns.FIRST`
    settings: Settings | None = None  # options that may change
    obstacles: tuple[Obstacle, ...] = ()  # obstacles of the cables other than each other and their platform
    live: frozenset[Role] = frozenset()  # parts without a warm-up: a reset would not undo its effects
    nominal: Robot | None = None  # nominal robot of controller and solver, if it differs from the robot
    more: tuple[LoopPart, ...] = ()  # further parts, of `cdpr.simulation.loop_parts`
    immediate: bool = True  # whether the tensions of the plant equal the commands that drives apply

    @property
    def named(self) -> tuple[tuple[str, Backend | Controller | LoopPart], ...]:
        """Parts that describe themselves in `run.json`, with their names: further parts, backend and controller."""
        own = (("backend", self.backend), ("controller", self.controller))
        return (*((part.name, part) for part in self.more), *own)

    @property
    def output_name(self) -> str:
        """Output of the controller in messages."""
        return "wrench" if self.output == "wrench" else "command"

    @property
    def ideal_cables(self) -> bool:
        """True if tensions equal commands; otherwise they are read from the backend, or are those of the drives."""
        return not GROUPS["winched"].within(self.columns)

    @property
    def perceived_robot(self) -> Robot:
        """Robot that the controller uses."""
        return self.nominal or self.robot

    @property
    def perceived_differs(self) -> bool:
        """True if controller and tension stage use another robot or state than the true one."""
        return perceived_differs(self.nominal, self.more)
