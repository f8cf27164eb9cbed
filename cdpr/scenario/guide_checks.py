"""A platform with a guide must start in it, and its motion must stay in it."""

from __future__ import annotations

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cdpr.model import DOF_NAMES
from cdpr.model.robot import Array
from cdpr.scenario.checks import Checks
from cdpr.scenario.fields import ZERO
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.problems import Path
from cdpr.scenario.robot_schema import DofName
from cdpr.scenario.schema import Initial
from cdpr.scenario.trajectory_schema import Hold, Knot, Quintic, Waypoint, Waypoints

# Entries of a quaternion or position below this are zero as typed: rounding of decimals, no motion.
HELD = 1e-9

DOF: TypeAdapter[tuple[DofName, ...]] = TypeAdapter(tuple[DofName, ...])
RATES = (
    ("velocity", slice(0, 3)),
    ("angular_velocity", slice(3, 6)),
    ("acceleration", slice(0, 3)),
    ("angular_acceleration", slice(3, 6)),
)


class GuideChecks(Checks):
    """Reports poses and rates that the guide does not allow."""

    def check(self, initial: Initial, trajectory: Hold | Quintic | Waypoints | None) -> None:
        """Look at the initial state and at every pose of the motion."""
        try:
            dof = DOF.validate_python(tuple(self.document.get(("robot", "dof")) or DOF_NAMES))
        except (ValidationError, TypeError):
            return
        self.held = np.array([name not in dof for name in DOF_NAMES])
        if not self.held.any():
            return
        self.free = f"the robot moves along {', '.join(dof)} only"
        self.home = np.array(initial.position)
        self._attitude(("initial", "orientation"), initial.orientation)
        self._rates(("initial",), initial)
        points: list[tuple[Path, Hold | Knot | Waypoint]] = []
        if isinstance(trajectory, Hold):
            points = [((), trajectory)]
        elif isinstance(trajectory, Quintic):
            points = [(("from",), trajectory.from_), (("to",), trajectory.to)]
        elif isinstance(trajectory, Waypoints):
            points = [(("points", k), point) for k, point in enumerate(trajectory.points)]
        for path, point in points:
            where: Path = ("trajectory", *path)
            if point.position is not None:
                self._position((*where, "position"), np.array(point.position))
            if point.orientation is not None:
                self._attitude((*where, "orientation"), point.orientation)
            if not isinstance(point, Hold):
                self._rates(where, point)

    def _position(self, path: Path, position: Array) -> None:
        away = self.held[:3] & (np.abs(position - self.home) > HELD)
        if away.any():
            axes = ", ".join(f"{'xyz'[i]} = {self.home[i]:g}" for i in np.flatnonzero(self.held[:3]))
            self.say(path, f"{self.free}; the initial position holds it at {axes} (m)")

    def _attitude(self, path: Path, orientation: Orientation) -> None:
        quaternion = orientation.quaternion()
        if (self.held[3:] & (np.abs(quaternion[1:]) > HELD)).any():
            hint = "describe a platform that is held at a slant by its anchors"
            self.say(path, f"{self.free}, so its attitude may differ from upright only about these; {hint}")

    def _rates(self, where: Path, point: Initial | Knot | Waypoint) -> None:
        for name, part in RATES:
            rate = np.array(getattr(point, name, None) or ZERO)
            if (self.held[part] & (rate != 0.0)).any():
                self.say((*where, name), f"{self.free}; zero is expected in the held directions")
