"""From the section of a loaded scenario to the desired motion."""

from __future__ import annotations

import numpy as np

from cdpr import trajectory
from cdpr.model.robot import Array
from cdpr.scenario.trajectory_schema import (
    AngularLimits,
    Circle,
    Csv,
    Helix,
    Hold,
    JerkLimited,
    Knot,
    Limits,
    Motion,
    PickAndPlace,
    Pose,
    Quintic,
    Stop,
    Waypoint,
)
from cdpr.trajectory import Trajectory


def make_trajectory(motion: Motion) -> Trajectory:
    """Turn a section, with the initial pose filled in (`Scenario.trajectory`), into the motion that it describes."""
    if isinstance(motion, Hold):
        return trajectory.hold(np.array(motion.position), motion.orientation.quaternion())
    if isinstance(motion, Quintic):
        return trajectory.through([_knot(motion.start, motion.from_), _knot(motion.end, motion.to)])
    if isinstance(motion, PickAndPlace):
        p0, q0 = _pose(motion.from_)
        p1, q1 = _pose(motion.to)
        return trajectory.arch(motion.start, motion.duration, (p0, p1), (q0, q1), motion.height, motion.vertical)
    if isinstance(motion, Circle):
        normal = np.array(motion.normal)
        return trajectory.circle(
            motion.start,
            motion.duration,
            *_pose(motion),
            np.array(motion.center),
            normal / np.linalg.norm(normal),
            motion.turns,
            pitch=motion.pitch if isinstance(motion, Helix) else 0.0,
            turning=motion.turning,
        )
    if isinstance(motion, JerkLimited):
        stops = [trajectory.Stop(*_pose(motion.from_)), *(trajectory.Stop(*_pose(p), p.pause) for p in motion.points)]
        angular = None if motion.angular_limits is None else _limits(motion.angular_limits)
        return trajectory.stop_to_stop(motion.start, stops, _limits(motion.limits), angular)
    if isinstance(motion, Csv):
        return _through_rows(motion)
    points = [_knot(motion.start + point.time, point) for point in motion.points]
    return trajectory.through(points) if len(points) > 1 else trajectory.hold(points[0].position, points[0].orientation)


def _through_rows(motion: Csv) -> Trajectory:
    table = motion.table
    attitudes = table.get("orientation")
    if attitudes is None:
        attitudes = np.tile(motion.orientation.quaternion(), (len(table.times), 1))
    rates = [table.get(name) for name in ("velocity", "angular_velocity", "acceleration")]
    return trajectory.interpolate(motion.start + table.times, table.columns["position"], attitudes, *rates)


def _knot(time: float, knot: Knot | Waypoint) -> trajectory.Knot:
    def given(values: tuple[float, ...] | None) -> Array | None:
        return None if values is None else np.array(values)

    return trajectory.Knot(
        time,
        np.array(knot.position),
        knot.orientation.quaternion(),
        given(knot.velocity),
        given(knot.angular_velocity),
        given(knot.acceleration),
        given(knot.angular_acceleration),
    )


def _pose(section: Pose | Stop | Circle) -> tuple[Array, Array]:
    return np.array(section.position), section.orientation.quaternion()


def _limits(section: Limits | AngularLimits) -> trajectory.Limits:
    return trajectory.Limits(section.velocity, section.acceleration, section.jerk)
