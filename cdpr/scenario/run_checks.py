"""Validation of a run across sections: time steps, initial state, obstacles and, with `motion_checks`, the motion."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

import numpy as np

from cdpr.base import tolerances
from cdpr.base.files import UnreadableError
from cdpr.base.problems import Path, shown
from cdpr.config.problems import exact
from cdpr.model import rotations
from cdpr.scenario.appearance import AT_ORIGIN, FrameSection, ObstacleSection
from cdpr.scenario.checks import Checks
from cdpr.scenario.drives_schema import Drives
from cdpr.scenario.initial import Initial
from cdpr.scenario.mesh import hull_of
from cdpr.scenario.motion_checks import MotionChecks
from cdpr.scenario.motions import Motion
from cdpr.scenario.robot_schema import CablesSection, PlatformSection, cable_name
from cdpr.scenario.schema import Log, Simulation, World
from cdpr.scenario.sensor_checks import SensorChecks

MAX_STEPS = 1e8


class RunChecks(Checks):
    """Checks of a scenario except the robot."""

    def run(self) -> Motion | None:
        """Report all problems; return the motion with its files loaded, or None."""
        initial = self.section(Initial, ("initial",))
        simulation = self.section(Simulation, ("simulation",))
        motion = MotionChecks(self.document, self.problems)
        motion.load()
        self.do(self.start)
        self._obstacles()
        self._contact()
        if simulation:
            self._steps(simulation)
            log = self.section(Log, ("log",))
            if log:
                self._multiple(("log", "step"), log.step, simulation.control_step)
            self._delays(simulation)
            SensorChecks(self.document, self.problems).check(simulation.control_step, self._multiple)
        motion.check(initial, simulation.duration if simulation else None)
        motion.guided(initial)
        return motion.motion

    def start(self) -> None:
        """Report cables without a defined direction at the initial pose."""
        initial = self.section(Initial, ("initial",))
        if initial is None:
            return
        cables = list(self.cables(("robot",)))
        anchors = np.array([[cable.frame, cable.platform] for _, cable in cables]).reshape(-1, 2, 3)
        tips = anchors[:, 1] @ rotations.matrix(initial.orientation.quaternion()).T + initial.position
        common = self.section(CablesSection, ("robot", "cable"))
        base = self.section(FrameSection, ("robot", "frame")) or AT_ORIGIN
        placed = base.placed(anchors[:, 0])
        lengths = np.linalg.norm(placed - tips, axis=1)
        for (i, cable), frame, tip, length in zip(cables, placed, tips, lengths, strict=True):
            leaves = base.leaving(cable.exit or (common.exit if common else None))
            why = leaves.obstacle(frame.tolist(), tip.tolist()) if leaves else ""
            if length < tolerances.LENGTH:
                why = "its two anchors coincide, so it has no direction"
            if why:
                self.add_problem(("initial", "position"), f"cable '{cable_name(cable, i)}' has no length here: {why}")

    def _obstacles(self) -> None:
        """Report unreadable or unusable obstacle meshes."""
        given = self.document.get(("world", "obstacles"))
        for i in range(len(given) if isinstance(given, list) else 0):
            path = ("world", "obstacles", i, "mesh")
            section = self.section(ObstacleSection, path[:-1])
            if section is None or section.mesh is None:
                continue
            if os.path.isabs(section.mesh):
                self.add_problem(
                    path, f"expected a file name relative to this file, got the absolute {shown(section.mesh)}"
                )
                continue
            try:
                hull_of(os.path.join(self.document.folder, section.mesh))
            except UnreadableError as error:
                self.add_problem(path, str(error))

    def _contact(self) -> None:
        """Report contact of a platform without a shape."""
        world, platform = self.section(World, ("world",)), self.section(PlatformSection, ("robot", "platform"))
        if world and world.contact and platform and platform.shape is None:
            self.add_problem(
                ("world", "contact"),
                "expected a platform with a shape, which touches the obstacles: add robot.platform.shape",
            )

    def _steps(self, simulation: Simulation) -> None:
        duration, control, physics = simulation.duration, simulation.control_step, simulation.physics_step
        count = max(duration, control) / min(control, physics)
        if count > MAX_STEPS:
            self.add_problem(("simulation", "duration"), f"{count:.3g} steps; at most {MAX_STEPS:g} are allowed")
            return
        if not _is_multiple(control, physics):
            near = _near(control / physics, lambda n: control / n)
            text = f"must be control_step, {exact(control)} (s), divided by an integer, got {exact(physics)}; "
            self.add_problem(("simulation", "physics_step"), f"{text}nearest: {near}")
        self._multiple(("simulation", "duration"), duration, control)

    def _delays(self, simulation: Simulation) -> None:
        """Report delays of drives that are no multiples of the control step, and unknown cables."""
        drives = self.section(Drives, ("drives",))
        if drives is None:
            return
        names = [cable_name(cable, i) for i, cable in self.cables(("robot",))]
        for name in drives.cables:
            if names and name not in names:
                text = f"unknown cable '{name}': expected one of {', '.join(names)}"
                self.add_problem(("drives", "cables", name), text)
        delays: dict[Path, float | None] = {("drives", "delay"): drives.delay}
        delays |= {("drives", "cables", name, "delay"): cable.delay for name, cable in drives.cables.items()}
        for path, delay in delays.items():
            if delay:
                self._multiple(path, delay, simulation.control_step)

    def _multiple(self, path: Path, value: float, control: float) -> None:
        if not _is_multiple(value, control):
            near = _near(value / control, lambda n: control * n)
            text = f"must be an integer multiple of control_step, {exact(control)} (s), got {exact(value)}; "
            self.add_problem(path, f"{text}nearest: {near}")


def _is_multiple(value: float, step: float) -> bool:
    ratio = value / step
    return abs(ratio - round(ratio)) <= tolerances.TIME * ratio


def _near(ratio: float, value: Callable[[int], float]) -> str:
    """Return the values for the integers below and above `ratio` as text."""
    below = math.floor(ratio)
    return " or ".join(f"{value(n):.12g}" for n in (below, below + 1) if n >= 1)
