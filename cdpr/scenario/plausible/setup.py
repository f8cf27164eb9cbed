"""Input of the checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from cdpr.base.problems import Path
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.rotations import matrix
from cdpr.model.shapes import Obstacle
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions import Motion
from cdpr.scenario.motions.motion import Place
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.schema import ScenarioSection, World
from cdpr.trajectory import Trajectory

Finding = tuple[Path, str]


@dataclass(frozen=True, eq=False)
class Setup:
    """Robot, with the scenario if there is one.

    Attributes:
        section: the robot as in its file.
        robot: the robot as arrays.
        root: path of the robot's section.
        data: plain data of the file.
        run: the scenario with defaults.
        motion: its motion as given, with the paths of the file.
        obstacles: obstacles of the scenario.
        desired: returns the desired motion.
        shortened: True if the duration was overridden for this call, so that a shorter run is intended.
        controller: declared properties of the controller.
        estimator: declared properties of the estimator; empty without one.
    """

    section: RobotSection
    robot: Robot
    root: Path
    data: dict[str, Any]
    run: ScenarioSection | None = None
    motion: Motion | None = None
    obstacles: tuple[Obstacle, ...] = ()
    desired: Callable[[], Trajectory] | None = None
    shortened: bool = False
    controller: Mapping[str, object] = field(default_factory=dict)
    estimator: Mapping[str, object] = field(default_factory=dict)

    @property
    def gravity(self) -> Array:
        """Acceleration of gravity, (3,), m/s^2, world frame."""
        return np.array((self.run.world if self.run else World.model_construct()).gravity)

    @property
    def middle(self) -> Array:
        """Centre of the frame's anchors, (3,), m, world frame."""
        return np.asarray(self.robot.anchors[:, :3].mean(axis=0))

    @property
    def extent(self) -> float:
        """Diagonal of the box around the frame's anchors, m."""
        return float(np.linalg.norm(np.ptp(self.robot.anchors[:, :3], axis=0)))

    def starts(self) -> Iterator[Place]:
        """Yield the robot's home, and the start of the run if it differs."""
        home = self.robot.home
        if home is not None:
            yield (*self.root, "home", "position"), home[:3], home[3:]
        if self.run is not None:
            state = self.run.initial.state()
            if home is None or not np.array_equal(state[:3], home[:3]):
                yield ("initial", "position"), state[:3], state[3:7]

    @property
    def begin(self) -> Initial:
        """Initial state of the moved point of a scenario."""
        assert self.run is not None
        assert self.motion is not None
        return self.motion.begins(self.run.initial, self.run.robot.platform.tools)

    @cached_property
    def places(self) -> tuple[list[Path], Array, Array]:
        """Distinct start and target poses: paths, positions (k, 3), m, and rotation matrices (k, 3, 3)."""
        found: dict[tuple[float, ...], Path] = {}
        for path, position, attitude in (*self.starts(), *self._wanted()):
            found.setdefault((*position.tolist(), *attitude.tolist()), path)
        poses = np.array(list(found)).reshape(-1, 7)
        attitudes, which = np.unique(poses[:, 3:], axis=0, return_inverse=True)
        turned = np.array([matrix(q) for q in attitudes]).reshape(-1, 3, 3)
        return list(found.values()), poses[:, :3], turned[which.ravel()]

    def _wanted(self) -> Iterator[Place]:
        """Yield the target poses of the motion and of events."""
        if self.run is None:
            return
        initial = self.run.initial
        if self.motion is not None:
            tools, tool = self.run.robot.platform.tools, self.motion.tool  # of the true robot
            for path, position, attitude in self.motion.places(self.begin):
                reach = 0.0 if tool is None else matrix(attitude) @ np.array(tools[tool])
                yield ("trajectory", *path), position - reach, attitude
        for i, event in enumerate(self.run.events):
            goal = event.goal()
            if goal is not None and goal.position is not None:
                turned = goal.orientation or initial.orientation
                yield ("events", i, "position"), np.array(goal.position), turned.quaternion()
