"""What a closed loop is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cdpr.columns import LATER, Column
from cdpr.model import Robot
from cdpr.model.shapes import Obstacle
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.controller import Output
from cdpr.plugins.info import Role
from cdpr.scenario.events import ScenarioEvent
from cdpr.simulation.settings import Settings
from cdpr.tension.policy import Policy
from cdpr.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Parts:
    """What a closed loop is made of."""

    robot: Robot
    controlled: Robot  # as the distribution knows it: its dof are the directions in which it has to balance the wrench
    trajectory: Trajectory
    controller: Controller
    solver: TensionSolver
    solver_name: str
    respects_bounds: bool
    policy: Policy
    backend: Backend
    control_step: float  # s
    substeps: int  # physics steps in a control step
    output: Output = "wrench"  # what the controller puts out
    events: tuple[ScenarioEvent, ...] = ()  # what happens during the run
    limits: Literal["warn", "stop"] = "warn"  # where a cable leaves its length or speed_max
    ideal_cables: bool = True  # otherwise tensions and work of the cables are read from the backend
    columns: tuple[Column, ...] = LATER  # what a row holds beyond `cdpr.columns.FIRST`
    settings: Settings | None = None  # options that may change
    obstacles: tuple[Obstacle, ...] = ()  # what cables may touch beside each other and their platform
    live: frozenset[Role] = (
        frozenset()
    )  # of whom nothing is tried before the run: what they do is not undone by a reset
    believed: Robot | None = None  # as controller and solver know it, where that is not the robot
