"""Duties of a robot's cables: motions, runs, whole workspaces, and the same with a broken cable."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.distribution import distribute
from cdpr.analysis.distribution.motion import follow
from cdpr.analysis.workspace.regions import Region
from cdpr.analysis.workspace.required import Required
from cdpr.base import defaults
from cdpr.base.errors import CdprError
from cdpr.log.run import Run
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.events import broken

MOST_CORNERS = 4096  # corners of a set of wrenches
MOST_SAMPLES = 2_000_000  # samples of a workspace; half a gigabyte with 8 cables


@dataclass(frozen=True, eq=False)
class Duty:
    """Motion and load of a robot's cables, K samples.

    Attributes:
        name: name of the source.
        robot: the robot.
        tension: (K, m), N; NaN for broken cables.
        length: (K, m), m, from exit to platform.
        feasible: (K,), True if tensions within the limits provide the wrench; other samples are ignored.
        time: (K,), s; None for unordered poses.
        rate: (K, m), m/s, rates of the lengths; None likewise.
        poses, wrenches: (K, 7) and (K, 6), platform poses and required wrenches.
        winch_tension: (K, m), N, at the winches of a run with friction on pulleys; None if it is the tension.
    """

    name: str
    robot: Robot
    tension: Array
    length: Array
    feasible: NDArray[np.bool_]
    time: Array | None
    rate: Array | None
    poses: Array
    wrenches: Array
    winch_tension: Array | None = None

    @classmethod
    def of_scenario(cls, scenario: Scenario, name: str) -> Duty:
        """Return the duty of a scenario's motion, without simulation, with the tensions of least 2-norm (`qp`)."""
        entry = registry().get("solver", defaults.SOLVER)
        motion = follow(scenario, entry.load()(scenario.controlled_robot, entry.info.options()).solve)
        names = [cable.name for cable in scenario.robot.cables]
        return cls(
            name,
            scenario.robot,
            _without(motion.tension, motion.time, broken(scenario.events, names, scenario.simulation.control_step)),
            motion.length,
            np.asarray(motion.feasible, dtype=bool),
            motion.time,
            motion.rate,
            motion.desired[:, :7],
            motion.wrench,
        )

    @classmethod
    def of_run(cls, run: Run, name: str) -> Duty:
        """Return the duty of a run.

        Raises:
            CdprError: if it has fewer than two samples.
        """
        if len(run.rows) < 2:
            raise CdprError(f"{name}: expected at least two samples")
        robot = load_scenario(f"scenario of {name}", text=run.header.scenario_yaml).robot
        poses = np.concatenate([run.position, run.orientation], axis=1)
        good = np.asarray(run.solver_status == 0.0)
        tension = _without(run.cable_tension, run.time, run.header.broken)
        winch = None
        if "winch_tension" in run.header.layout.fields:
            winch = _without(run.winch_tension, run.time, run.header.broken)
        return cls(name, robot, tension, run.length, good, run.time, run.rate, poses, run.wrench, winch)


def over_workspace(robot: Robot, region: Region, required: Required, gravity: Array) -> Duty:
    """Return the static duty in all cells and attitudes of a region, with the weight and each corner of a wrench set.

    Raises:
        CdprError: if the set has no corners, as an ellipsoid, or more than `MOST_CORNERS`, or if there are more than
            `MOST_SAMPLES` samples.
    """
    corners = _corners(required)
    count = region.cells * len(region.orientations) * len(corners)
    if count > MOST_SAMPLES:
        raise CdprError(
            f"cells: {region.cells} cells with {len(corners)} wrenches in each are {count} samples, at most "
            f"{MOST_SAMPLES} are allowed: choose fewer cells"
        )
    places = region.positions(np.arange(region.cells))
    turned = np.repeat(region.orientations, len(places), axis=0)
    poses = np.concatenate([np.tile(places, (len(region.orientations), 1)), turned], axis=1)
    weight = np.array([required_wrench(robot, make_state(p[:3], p[3:]), gravity) for p in poses])
    wrenches = (weight[:, None, :] + corners).reshape(-1, 6)
    every = np.repeat(poses, len(corners), axis=0)
    found = distribute(robot, every, wrenches)
    length = np.repeat(np.array([lengths(robot, make_state(p[:3], p[3:])) for p in poses]), len(corners), axis=0)
    feasible = np.asarray(found.feasible, dtype=bool)
    return Duty("workspace", robot, found.tension, length, feasible, None, None, every, wrenches)


def with_one_broken(duty: Duty) -> Iterator[Duty]:
    """Yield the same duty for each cable broken, with tensions of the other cables by the solver `qp`."""
    robot = duty.robot
    for i, cable in enumerate(robot.cables):
        lost = np.isnan(duty.tension)
        lost[:, i] = True
        low, high = (np.where(lost, 0.0, limit) for limit in (robot.tension_min, robot.tension_max))
        found = distribute(robot, duty.poses, duty.wrenches, solver=defaults.SOLVER, tension_min=low, tension_max=high)
        tension = np.where(lost, np.nan, found.tension)
        name = f"{duty.name}, {cable.name} broken"
        rest = duty.time, duty.rate, duty.poses, duty.wrenches
        yield Duty(name, robot, tension, duty.length, np.asarray(found.feasible, dtype=bool), *rest)


def _without(tension: Array, time: Array, broken: Sequence[tuple[int, float]]) -> Array:
    """Return tensions (K, m) with NaN for cables after they broke."""
    left = tension.copy()
    for i, at in broken:
        left[time >= at, i] = np.nan
    return left


def _corners(required: Required) -> Array:
    if required.form == "vertices":
        return required.vectors
    if required.accelerations or required.form == "ellipsoid" or 2 ** len(required.vectors) > MOST_CORNERS:
        raise CdprError(f"the required set must be one of wrenches with at most {MOST_CORNERS} corners, such as a box")
    return np.array(
        [np.array(signs) @ required.vectors for signs in itertools.product((-1, 1), repeat=len(required.vectors))]
    )
