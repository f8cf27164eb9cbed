"""What no single section of a run can see: steps, the start, and a motion that fits the run."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cdpr.model import rotations
from cdpr.scenario.checks import MIN_LENGTH, Checks
from cdpr.scenario.fields import ZERO
from cdpr.scenario.guide_checks import GuideChecks
from cdpr.scenario.problems import Path
from cdpr.scenario.robot_schema import cable_name
from cdpr.scenario.schema import Initial, Simulation
from cdpr.scenario.trajectory_schema import Hold, Knot, Quintic, Trajectory, Waypoint, Waypoints

RATIO_TOLERANCE = 1e-9  # relative; steps are decimal fractions, which floats miss by rounding
MAX_STEPS = 1e8

TRAJECTORY: TypeAdapter[Hold | Quintic | Waypoints] = TypeAdapter(Trajectory)


class RunChecks(Checks):
    """Checks everything of a scenario beyond the robot itself."""

    def run(self) -> None:
        """Report everything that is wrong."""
        initial = self.section(Initial, ("initial",))
        simulation = self.section(Simulation, ("simulation",))
        trajectory = self._trajectory()
        if initial:
            self._start(initial)
        if simulation:
            self._steps(simulation)
        if isinstance(trajectory, Waypoints):
            self._times(trajectory)
        if initial:
            GuideChecks(self.document, self.problems).check(initial, trajectory)
        if simulation and trajectory:
            self._rest_outside(trajectory, simulation.duration)

    def _trajectory(self) -> Hold | Quintic | Waypoints | None:
        if "trajectory" not in self.document.data:
            return None
        try:
            return TRAJECTORY.validate_json(json.dumps(self.document.get(("trajectory",))))
        except ValidationError:
            return None

    def _start(self, initial: Initial) -> None:
        R = rotations.matrix(initial.orientation.quaternion())
        for i, cable in self.cables(("robot",)):
            end = np.array(initial.position) + R @ np.array(cable.platform)
            if np.linalg.norm(np.array(cable.frame) - end) < MIN_LENGTH:
                name = cable_name(cable, i)
                text = f"cable '{name}' has no length here: its two anchors coincide, so it has no direction"
                self.say(("initial", "position"), text)

    def _steps(self, simulation: Simulation) -> None:
        duration, control, physics = simulation.duration, simulation.control_step, simulation.physics_step
        count = max(duration, control) / min(control, physics)
        if count > MAX_STEPS:
            self.say(("simulation", "duration"), f"{count:.3g} steps; at most {MAX_STEPS:g} are allowed")
            return
        if not _is_multiple(control, physics):
            near = _near(control / physics, lambda n: control / n)
            text = f"must be control_step, {control:g} (s), divided by an integer, got {physics:g}; "
            self.say(("simulation", "physics_step"), f"{text}nearest: {near}")
        if not _is_multiple(duration, control):
            near = _near(duration / control, lambda n: control * n)
            text = f"must be an integer multiple of control_step, {control:g} (s), got {duration:g}; "
            self.say(("simulation", "duration"), f"{text}nearest: {near}")

    def _times(self, trajectory: Waypoints) -> None:
        times = [point.time for point in trajectory.points]
        for k in range(1, len(times)):
            if times[k] <= times[k - 1]:
                text = f"must be greater than the previous point's, {times[k - 1]:g} (s), got {times[k]:g}"
                self.say(("trajectory", "points", k, "time"), text)
        if times == [0.0]:
            text = "a point with a time greater than 0 is expected; to stay, use type: hold"
            self.say(("trajectory", "points"), text)

    def _rest_outside(self, trajectory: Hold | Quintic | Waypoints, duration: float) -> None:
        """Before and after the motion a pose is held, so the motion must start and end at rest there."""
        if isinstance(trajectory, Hold):
            return
        points: list[tuple[Path, Knot | Waypoint]]
        if isinstance(trajectory, Quintic):
            points = [(("from",), trajectory.from_), (("to",), trajectory.to)]
        else:
            points = [(("points", k), point) for k, point in enumerate(trajectory.points)]
        start, end = trajectory.start, trajectory.end
        starts_at_initial = isinstance(trajectory, Waypoints) and trajectory.points[0].time > 0
        if start > 0 and not starts_at_initial:
            self._at_rest(*points[0], f"the pose is held until {start:g} s, so the motion must start at rest")
        if end < duration * (1.0 - RATIO_TOLERANCE):
            text = f"the motion ends at {end:g} s and the run at {duration:g} s, so the motion must end at rest"
            self._at_rest(*points[-1], text)

    def _at_rest(self, path: Path, point: Knot | Waypoint, text: str) -> None:
        for name in ("velocity", "angular_velocity"):
            if any(getattr(point, name) or ZERO):
                self.say(("trajectory", *path, name), text)


def _is_multiple(value: float, step: float) -> bool:
    ratio = value / step
    return abs(ratio - round(ratio)) <= RATIO_TOLERANCE * ratio


def _near(ratio: float, value: Callable[[int], float]) -> str:
    """Name the values that belong to the integers on both sides of `ratio`."""
    below = math.floor(ratio)
    return " or ".join(f"{value(n):.12g}" for n in (below, below + 1) if n >= 1)
