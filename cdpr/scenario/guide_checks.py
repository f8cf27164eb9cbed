"""A platform with a guide must start in it, and its motion must stay in it."""

from __future__ import annotations

import os

import numpy as np

from cdpr.model import DOF_NAMES
from cdpr.model.robot import Array
from cdpr.scenario.checks import Checks
from cdpr.scenario.fields import ZERO
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.problems import Mark, Path, exact
from cdpr.scenario.schema import Initial
from cdpr.scenario.trajectory_schema import Circle, Csv, Helix, Knot, Motion, PickAndPlace, Waypoint, poses

# Entries of a quaternion or position below this are zero as typed: rounding of decimals, no motion.
HELD = 1e-9

RATES = (
    ("velocity", slice(0, 3)),
    ("angular_velocity", slice(3, 6)),
    ("acceleration", slice(0, 3)),
    ("angular_acceleration", slice(3, 6)),
)


class GuideChecks(Checks):
    """Reports poses and rates that the guide does not allow."""

    def controlled(self) -> None:
        """Look at the directions in which the cables are to exert a wrench."""
        if self.document.get(("controlled",)) is None:
            return
        dof, controlled = self.directions(("robot", "dof")), self.directions(("controlled",))
        if dof and controlled and (held := [name for name in controlled if name not in dof]):
            text = f"the robot does not move along {', '.join(held)}; allowed are any of {', '.join(dof)}"
            self.say(("controlled",), text)

    def check(self, initial: Initial, motion: Motion | None) -> None:
        """Look at the initial state and at every pose of the motion."""
        dof = self.directions(("robot", "dof"))
        if not dof:
            return
        self.held = np.array([name not in dof for name in DOF_NAMES])
        if not self.held.any():
            return
        self.free = f"the robot moves along {', '.join(dof)} only"
        self.home = np.array(initial.position)
        self._attitude(("initial", "orientation"), initial.orientation)
        self._rates(("initial",), initial)
        for path, point in poses(motion) if motion else []:
            where: Path = ("trajectory", *path)
            if point.position is not None:
                self._position((*where, "position"), np.array(point.position))
            if point.orientation is not None:
                self._attitude((*where, "orientation"), point.orientation)
            if isinstance(point, Knot | Waypoint):
                self._rates(where, point)
        if isinstance(motion, Circle):
            self._circle(motion)
        elif isinstance(motion, PickAndPlace) and motion.height > 0.0 and self.held[2]:
            self.say(("trajectory", "height"), f"{self.free}, so 0 is expected, got {exact(motion.height)}")
        elif isinstance(motion, Csv):
            self._table(motion)

    def _circle(self, motion: Circle) -> None:
        """Between its poses, which are one, a circle goes where its plane does."""
        if self.held[:3].sum() > 1:
            text = f"{self.free}, so no circle can be passed; others move as they say: quintic, waypoints, jerk_limited"
            self.say(("trajectory", "type"), text)
            return
        normal = np.array(motion.normal)
        length = float(np.linalg.norm(normal))
        if length == 0.0:
            return
        normal /= length
        if (self.held[:3] & (np.sqrt(np.maximum(1.0 - normal**2, 0.0)) > HELD)).any():
            axes = ", ".join("xyz"[i] for i in np.flatnonzero(self.held[:3]))
            self.say(("trajectory", "normal"), f"{self.free}, so the circle must not leave its plane: normal to {axes}")
        if isinstance(motion, Helix) and (self.held[:3] & (np.abs(motion.pitch * normal) > HELD)).any():
            self.say(("trajectory", "pitch"), f"{self.free}, so the path must not climb along the normal")
        if motion.turning and (self.held[3:] & (np.abs(normal) > HELD)).any():
            self.say(("trajectory", "turning"), f"{self.free}, so the platform cannot turn about the normal")

    def _table(self, motion: Csv) -> None:
        """Report the first point of each kind that the guide does not allow."""
        if motion.orientation is not None:
            self._attitude(("trajectory", "orientation"), motion.orientation)
        table = motion.table
        away: list[tuple[str, Array, slice]] = [("position", table.columns["position"] - self.home, slice(0, 3))]
        attitudes = table.get("orientation")
        if attitudes is not None:
            away.append(("orientation", attitudes[:, 1:], slice(3, 6)))
        for name, part in RATES:
            rates = table.get(name)
            if rates is not None:
                away.append((name, rates, part))
        for name, values, part in away:
            wrong = np.flatnonzero((self.held[part] & (np.abs(values) > HELD)).any(axis=1))
            if len(wrong):
                mark = Mark(os.path.join(self.document.folder, motion.file), table.lines[wrong[0]], 1)
                text = f"{name.replace('_', ' ')}: {self.free}"
                self.problems.add(mark, ("trajectory", "file"), f"{text}; see also {len(wrong) - 1} points more")

    def _position(self, path: Path, position: Array) -> None:
        away = self.held[:3] & (np.abs(position - self.home) > HELD)
        if away.any():
            axes = ", ".join(f"{'xyz'[i]} = {exact(self.home[i])}" for i in np.flatnonzero(self.held[:3]))
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
