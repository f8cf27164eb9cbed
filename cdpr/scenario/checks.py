"""What no single section can see: how cables, steps, motion and start fit together.

Each check looks at the parts that are right by themselves, so that one wrong number does not hide the next
problem.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cdpr.model import rotations
from cdpr.scenario.document import Document
from cdpr.scenario.fields import ZERO, Section
from cdpr.scenario.problems import Path, Problems
from cdpr.scenario.robot_schema import CableSection, CableTension, TensionSection, cable_name, limits
from cdpr.scenario.schema import Initial, Simulation
from cdpr.scenario.trajectory_schema import Hold, Knot, Quintic, Trajectory, Waypoint, Waypoints

MIN_LENGTH = 1e-6  # m; a shorter cable has no direction, and anchors nearer than this are one point
RATIO_TOLERANCE = 1e-9  # relative; steps are decimal fractions, which floats miss by rounding
MAX_STEPS = 1e8


class Checker:
    """Runs the checks of one document and reports what they find."""

    def __init__(self, document: Document, problems: Problems) -> None:
        self.document = document
        self.problems = problems

    def robot(self, root: Path) -> None:
        """Check the robot whose section stands at `root`."""
        cables = list(self._cables(root))
        self._names(root, cables)
        self._coincident(root, cables)
        self._tensions(root, cables)

    def scenario(self) -> None:
        """Check everything beyond the robot itself."""
        initial = self._part(Initial, ("initial",))
        simulation = self._part(Simulation, ("simulation",))
        trajectory: Hold | Quintic | Waypoints | None
        trajectory = self._part(Trajectory, ("trajectory",)) if "trajectory" in self.document.data else Hold()
        if initial:
            self._start(initial)
        if simulation:
            self._steps(simulation)
        if isinstance(trajectory, Waypoints):
            self._times(trajectory)
        if simulation and trajectory:
            self._rest_outside(trajectory, simulation.duration)

    def _part(self, kind: Any, path: Path) -> Any:
        """Return the part at `path` if it is right but for unknown keys, else None."""
        data = self.document.get(path)
        if isinstance(data, dict) and isinstance(kind, type) and issubclass(kind, Section):
            data = {key: value for key, value in data.items() if key in kind.model_fields}
        try:
            return TypeAdapter(kind).validate_json(json.dumps(data))
        except ValidationError:
            return None

    def _say(self, path: Path, text: str) -> None:
        self.problems.add(self.document.mark(path), path, text)

    def _cables(self, root: Path) -> Iterator[tuple[int, CableSection]]:
        given = self.document.get((*root, "cables"))
        for i in range(len(given) if isinstance(given, list) else 0):
            cable = self._part(CableSection, (*root, "cables", i))
            if cable:
                yield i, cable

    def _names(self, root: Path, cables: list[tuple[int, CableSection]]) -> None:
        first: dict[str, int] = {}
        for i, cable in cables:
            name = cable_name(cable, i)
            if name in first:
                text = f"'{name}' is the name of cables[{first[name]}] too; names must differ"
                self._say((*root, "cables", i, "name"), text)
            first.setdefault(name, i)

    def _coincident(self, root: Path, cables: list[tuple[int, CableSection]]) -> None:
        anchors = np.array([[cable.frame, cable.platform] for _, cable in cables]).reshape(-1, 2, 3)
        for b in range(1, len(cables)):
            distances = np.linalg.norm(anchors[:b] - anchors[b], axis=2)  # (b, 2), m
            same = np.flatnonzero(np.all(distances < MIN_LENGTH, axis=1))
            if len(same):
                other = f"cables[{cables[int(same[0])][0]}]"
                text = f"coincides with {other} at both ends, so they are one cable (sharing one end is fine)"
                self._say((*root, "cables", cables[b][0]), text)

    def _tensions(self, root: Path, cables: list[tuple[int, CableSection]]) -> None:
        common: TensionSection | None = self._part(TensionSection, (*root, "tension"))
        if common is None:
            return
        given = self.document.get((*root, "cables"))
        if not isinstance(given, list):
            return
        count = len(given)
        right = True
        for name, value in (("min", common.min), ("max", common.max)):
            if isinstance(value, list) and len(value) != count:
                self._say(
                    (*root, "tension", name), f"{count} numbers expected (N), one per cable, got {len(value)}"
                )
                right = False
        if not right:
            return
        unilateral = self.document.get((*root, "unilateral")) is not False
        said: set[Path] = set()
        for i, cable in cables:
            low, high = limits(common, cable, i)
            for path, text in self._limit_faults(root, common, cable, i, (low, high), unilateral):
                if path not in said:
                    said.add(path)
                    self._say(path, text)

    def _limit_faults(
        self,
        root: Path,
        common: TensionSection,
        cable: CableSection,
        i: int,
        limit: tuple[float, float],
        unilateral: bool,
    ) -> Iterator[tuple[Path, str]]:
        low, high = limit
        own = cable.tension or CableTension()
        at_min = _limit_path(root, common.min, own.min, "min", i)
        at_max = _limit_path(root, common.max, own.max, "max", i)
        if unilateral and low < 0:
            yield (
                at_min,
                f"must be at least 0 (N), got {low:g}: a cable cannot push (rigid legs: unilateral: false)",
            )
        if high <= 0:
            yield at_max, f"must be greater than 0 (N), got {high:g}: a cable must be able to pull"
        elif low > high:
            yield at_min, f"must not exceed the highest tension of this cable, {high:g} (N), got {low:g}"

    def _start(self, initial: Initial) -> None:
        R = rotations.matrix(initial.orientation.quaternion())
        for i, cable in self._cables(("robot",)):
            end = np.array(initial.position) + R @ np.array(cable.platform)
            if np.linalg.norm(np.array(cable.frame) - end) < MIN_LENGTH:
                name = cable_name(cable, i)
                text = f"cable '{name}' has no length here: its two anchors coincide, so it has no direction"
                self._say(("initial", "position"), text)

    def _steps(self, simulation: Simulation) -> None:
        duration, control, physics = simulation.duration, simulation.control_step, simulation.physics_step
        count = max(duration, control) / min(control, physics)
        if count > MAX_STEPS:
            self._say(("simulation", "duration"), f"{count:.3g} steps; at most {MAX_STEPS:g} are allowed")
            return
        if not _is_multiple(control, physics):
            near = _near(control / physics, lambda n: control / n)
            text = f"must be control_step, {control:g} (s), divided by an integer, got {physics:g}; "
            self._say(("simulation", "physics_step"), f"{text}nearest: {near}")
        if not _is_multiple(duration, control):
            near = _near(duration / control, lambda n: control * n)
            text = f"must be an integer multiple of control_step, {control:g} (s), got {duration:g}; "
            self._say(("simulation", "duration"), f"{text}nearest: {near}")

    def _times(self, trajectory: Waypoints) -> None:
        times = [point.time for point in trajectory.points]
        for k in range(1, len(times)):
            if times[k] <= times[k - 1]:
                text = f"must be greater than the previous point's, {times[k - 1]:g} (s), got {times[k]:g}"
                self._say(("trajectory", "points", k, "time"), text)
        if times == [0.0]:
            text = "a point with a time greater than 0 is expected; to stay, use type: hold"
            self._say(("trajectory", "points"), text)

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
            text = (
                f"the motion ends at {end:g} s and the run at {duration:g} s, so the motion must end at rest"
            )
            self._at_rest(*points[-1], text)

    def _at_rest(self, path: Path, point: Knot | Waypoint, text: str) -> None:
        for name in ("velocity", "angular_velocity"):
            if any(getattr(point, name) or ZERO):
                self._say(("trajectory", *path, name), text)


def _limit_path(root: Path, common: Any, own: float | None, name: str, i: int) -> Path:
    """Where a limit of cable i was written."""
    if own is not None:
        return (*root, "cables", i, "tension", name)
    return (*root, "tension", name, i) if isinstance(common, list) else (*root, "tension", name)


def _is_multiple(value: float, step: float) -> bool:
    ratio = value / step
    return round(ratio) >= 1 and abs(ratio - round(ratio)) <= RATIO_TOLERANCE * ratio


def _near(ratio: float, value: Callable[[int], float]) -> str:
    """Name the values that belong to the integers on both sides of `ratio`."""
    below = math.floor(ratio)
    return " or ".join(f"{value(n):.12g}" for n in (below, below + 1) if n >= 1)
