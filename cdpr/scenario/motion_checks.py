"""A motion that fits the run: times that rise, rest where a pose is held, a path that exists."""

from __future__ import annotations

import json
import os
from itertools import pairwise

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cdpr.model import rotations
from cdpr.scenario.checks import MIN_LENGTH, Checks
from cdpr.scenario.fields import ZERO
from cdpr.scenario.files import UnreadableError, read
from cdpr.scenario.problems import Mark, Path, exact, shown
from cdpr.scenario.schema import Initial
from cdpr.scenario.table import MAX_BYTES, Table, TableError, parse_table
from cdpr.scenario.trajectory_schema import (
    Circle,
    Csv,
    JerkLimited,
    Knot,
    Motion,
    Quintic,
    Trajectory,
    Waypoint,
    Waypoints,
    complete,
    poses,
)

SHORTER = 1e-9  # relative; a motion ends before the run if by more than rounding
NO_TURN = 1e-9  # rad; attitudes nearer than this are one

TRAJECTORY: TypeAdapter[Motion] = TypeAdapter(Trajectory)


class MotionChecks(Checks):
    """Checks the desired motion.

    Attributes:
        motion: the section, with its file read; None where it is wrong by itself.
        table: what its file holds, if it has one.
    """

    table: Table | None = None
    motion: Motion | None = None

    def read(self) -> None:
        """Find the section and read its file."""
        if "trajectory" not in self.document.data:
            return
        try:
            self.motion = TRAJECTORY.validate_json(json.dumps(self.document.get(("trajectory",))))
        except ValidationError:
            return
        if isinstance(self.motion, Csv):
            self.table = self._read_table(self.motion)
            self.motion = self.motion.filled(self.table) if self.table else None

    def check(self, initial: Initial | None, duration: float | None) -> None:
        """Report what is wrong, of a run that lasts `duration` (s)."""
        motion = self.motion
        if motion is None:
            return
        if isinstance(motion, Waypoints):
            self._times(motion)
        if initial:
            completed = complete(motion, initial)
            if isinstance(completed, Circle):
                self._circle(completed)
            elif isinstance(completed, JerkLimited):
                self._turns(completed)
        if duration:
            self._rest_outside(motion, duration)

    def _read_table(self, motion: Csv) -> Table | None:
        where: Path = ("trajectory", "file")
        if os.path.isabs(motion.file):
            self.say(where, f"a file name relative to this file is expected, got the absolute {shown(motion.file)}")
            return None
        path = os.path.join(self.document.folder, motion.file)
        try:
            table = parse_table(read(path, MAX_BYTES, (".csv",)))
        except UnreadableError as error:
            self.say(where, str(error))
            return None
        except TableError as error:
            for line, column, text in error.faults:
                self.problems.add(Mark(path, line, column or 1), where, text)
            return None
        if motion.sha256 not in (None, table.sha256):
            self.say(("trajectory", "sha256"), f"'{path}' has changed: its checksum is {table.sha256}")
        return table

    def _times(self, motion: Waypoints) -> None:
        times = [point.time for point in motion.points]
        for k in range(1, len(times)):
            if times[k] <= times[k - 1]:
                text = f"must be greater than the previous point's, {exact(times[k - 1])} (s), got {exact(times[k])}"
                self.say(("trajectory", "points", k, "time"), text)
        if times == [0.0]:
            text = "a point with a time greater than 0 is expected; to stay, use type: hold"
            self.say(("trajectory", "points"), text)

    def _circle(self, motion: Circle) -> None:
        if motion.turns == 0.0:
            self.say(("trajectory", "turns"), "must not be 0; to stay, use type: hold")
        length = float(np.linalg.norm(motion.normal))
        if length < MIN_LENGTH:
            self.say(
                ("trajectory", "normal"), f"must not be zero; that of a level circle is [0, 0, 1], got {exact(length)}"
            )
            return
        normal = np.array(motion.normal) / length
        arm = np.array(motion.position) - motion.center
        climb = float(arm @ normal)
        if np.linalg.norm(arm - climb * normal) < MIN_LENGTH:
            self.say(("trajectory", "center"), "the circle has no radius: its beginning lies on its axis")
        elif abs(climb) > MIN_LENGTH:
            near = ", ".join(f"{value:.9g}" for value in motion.center + climb * normal)
            text = f"lies {abs(climb):.6g} m out of the plane of the circle's beginning; nearest in it: [{near}]"
            self.say(("trajectory", "center"), text)

    def _turns(self, motion: JerkLimited) -> None:
        if motion.angular_limits:
            return
        for (_, before), (path, after) in pairwise(poses(motion)):
            q = rotations.multiply(rotations.conjugate(before.orientation.quaternion()), after.orientation.quaternion())
            if np.linalg.norm(rotations.rotation_vector(q)) > NO_TURN:
                keys = "velocity, acceleration and jerk in rad/s, rad/s^2, rad/s^3"
                text = f"required as the attitude changes on the way to point {path[-1]}: {keys}"
                self.say(("trajectory", "angular_limits"), text)
                return

    def _rest_outside(self, motion: Motion, duration: float) -> None:
        """Before and after the motion a pose is held, so the motion must start and end at rest there."""
        if isinstance(motion, Csv):
            start, end = (motion.start + float(motion.table.times[k]) for k in (0, -1))
        elif isinstance(motion, Quintic | Waypoints):
            start, end = motion.start, motion.end
        else:
            return  # at rest there by themselves
        starts_at_initial = isinstance(motion, Waypoints) and motion.points[0].time > 0
        if start > 0 and not starts_at_initial:
            self._at_rest(motion, 0, f"the pose is held until {exact(start)} s, so the motion must start at rest")
        if end < duration * (1.0 - SHORTER):
            text = (
                f"the motion ends at {exact(end)} s and the run at {exact(duration)} s, so the motion must end at rest"
            )
            self._at_rest(motion, -1, text)

    def _at_rest(self, motion: Motion, k: int, text: str) -> None:
        for name in ("velocity", "angular_velocity"):
            if isinstance(motion, Csv):
                rates = motion.table.get(name)
                if rates is not None and rates[k].any():
                    self.say_row(motion, k, f"{name.replace('_', ' ')}: {text}")
                continue
            path, point = poses(motion)[k]
            assert isinstance(point, Knot | Waypoint)
            if any(getattr(point, name) or ZERO):
                self.say(("trajectory", *path, name), text)

    def say_row(self, motion: Csv, k: int, text: str) -> None:
        """Report a problem of the k-th point of a file."""
        path = os.path.join(self.document.folder, motion.file)
        self.problems.add(Mark(path, motion.table.lines[k], 1), ("trajectory", "file"), text)
