"""Description of a run before its first step: robot, plugins, versions, desired path."""

from __future__ import annotations

import math
import platform
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from cdpr.base.version import VERSION
from cdpr.cables import exits_of, spans_of
from cdpr.log.header import SOLIDS, Header
from cdpr.mechanics.reach import bounds_of
from cdpr.model import rotations
from cdpr.native.operations import kernels_version
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario import Scenario
from cdpr.scenario.events import broken
from cdpr.scenario.events.limit_changes import limit_changes
from cdpr.scene.path import thinned
from cdpr.sensing.rays import solids_of
from cdpr.simulation.cameras import imaging_of
from cdpr.simulation.columns import listed
from cdpr.simulation.works import works_of
from cdpr.trajectory import Trajectory

# Libraries used by the arithmetic of every run.
LIBRARIES = ("numpy",)

# Desired path for viewers: sampled every 20 ms, in which a platform moves some millimetres round a corner, with a lower
# limit for short runs and an upper limit for runs of minutes; simplified to this share of the robot's characteristic
# length.
PATH_STEP, PATH_POINTS = 0.02, (201, 20_001)  # s, points
PATH_TOLERANCE = 1e-3


def make_header(scenario: Scenario) -> Header:
    """Return the metadata of the run; equal for equal scenario, seed and versions.

    Raises:
        PluginError: if a plugin is unknown, its requirements are not installed, or two columns have one name.
    """
    robot, simulation = scenario.robot, scenario.simulation
    return Header(
        scenario=scenario.name,
        robot=robot.name,
        backend=simulation.backend,
        controller=scenario.controller.type,
        solver=scenario.solver.type,
        control_step=simulation.control_step,
        physics_step=simulation.physics_step,
        seed=simulation.seed,
        gravity=tuple(scenario.world.gravity),
        mass=robot.platform.mass,
        cables=tuple(cable.name for cable in robot.cables),
        anchors=tuple(tuple(row) for row in robot.anchors.tolist()),
        tension_min=tuple(robot.tension_min.tolist()),
        tension_max=tuple(robot.tension_max.tolist()),
        characteristic_length=robot.characteristic_length,
        shape=robot.platform.outline,
        controlled=scenario.controlled_dof if scenario.controlled_dof != robot.dof else (),
        versions=versions_of(scenario.plugins, plugins_of(scenario)),
        scenario_yaml=scenario.resolved_yaml(),
        cable_model=scenario.cable_model,
        log_every=scenario.log_every,
        bounds=bounds_of(robot),
        broken=broken(scenario.events, [cable.name for cable in robot.cables], simulation.control_step),
        limit_changes=limit_changes(scenario.events, robot, simulation.control_step),
        exits=exits_of(robot),
        spans=spans_of(robot),
        columns=listed(scenario),
        frame=tuple(tuple(row) for row in robot.frame.edges.tolist()) if robot.frame else (),
        colours=robot.colours,
        path=desired_path(scenario),
        tools={name: tuple(point.tolist()) for name, point in robot.platform.tools.items()},
        tool=scenario.trajectory.tool or "",
        believed=scenario.nominal_differences,
        imaging=imaging_of(scenario),
        estimator="" if scenario.estimator is None else scenario.estimator.type,
        works=works_of(scenario),
        sensors=sensor_sections(scenario),
    )


def sensor_sections(scenario: Scenario) -> tuple[dict[str, Any], ...]:
    """Return the sections of the sensors, with their names, for viewers and messages."""
    sections: list[dict[str, Any]] = []
    for each in scenario.sections.sensors:
        sections.append({**each.model_dump(mode="json"), "name": each.title})
        if each.sees_obstacles:
            sections[-1][SOLIDS] = solids_of(scenario.obstacles).tolist()
    return tuple(sections)


def desired_path(scenario: Scenario) -> tuple[tuple[float, ...], ...]:
    """Return points (k, 3), m, of the scenario's desired path for drawing; one point without motion.

    The path is that of the tool that the motion guides, otherwise that of the platform's origin.
    """
    end = scenario.simulation.steps * scenario.simulation.control_step
    tool = scenario.trajectory.tool
    arm = (0.0, 0.0, 0.0) if tool is None else tuple(scenario.robot.platform.tools[tool].tolist())
    return _path(scenario.desired, end, PATH_TOLERANCE * scenario.robot.characteristic_length, arm)


@lru_cache(maxsize=4)  # cases of a study share their motion
def _path(wanted: Trajectory, end: float, tolerance: float, arm: tuple[float, ...]) -> tuple[tuple[float, ...], ...]:
    """Return points of a motion up to `end`, s, simplified to the tolerance, m."""
    fewest, most = PATH_POINTS
    times = np.linspace(0.0, end, min(max(fewest, math.ceil(end / PATH_STEP) + 1), most))
    poses, desired = np.empty((len(times), 7)), np.empty(19)
    sample = wanted.sampler(desired)
    for pose, time in zip(poses, times.tolist(), strict=True):
        sample(time)
        pose[:] = desired[:7]
    path = poses[:, :3] + rotations.rotate(poses[:, 3:], np.array(arm)) if any(arm) else poses[:, :3]
    path = thinned(path, tolerance)
    if len(path) == 2 and np.array_equal(*path):
        path = path[:1]
    return tuple(tuple(point) for point in path.round(6).tolist())  # micrometres


def plugins_of(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of backend, controller, solver and, if there is one, estimator."""
    estimator = () if scenario.estimator is None else (scenario.estimator.type,)
    return scenario.simulation.backend, scenario.controller.type, scenario.solver.type, *estimator


@lru_cache
def _version(name: str) -> str:
    """Return the version of a distribution, read once: this process does not use what is installed later."""
    return version(name)


def versions_of(found: Registry, plugins: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of cdpr, Python, our libraries and the requirements of these plugins, see `plugins_of`.

    Raises:
        PluginError: if a plugin is unknown or its requirements are not installed.
    """
    versions = {"cdpr": VERSION, "kernels": kernels_version(), "python": platform.python_version()}
    names = set(LIBRARIES)
    roles: tuple[Role, ...] = ("backend", "controller", "solver", "estimator")
    for role, plugin in zip(roles, plugins, strict=False):
        entry = found.get(role, plugin)
        if entry.missing:
            entry.load()  # raises the remedy for a missing requirement before anything is written
        names |= set(entry.info.requires)
        if entry.distribution != "cdpr":
            versions[entry.distribution] = entry.version
    for name in sorted(names - set(versions)):
        try:
            versions[name] = _version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return versions
