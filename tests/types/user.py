"""A user's file: mypy must know the type of everything public, and refuse what does not exist. See test_types.py."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, assert_type

import numpy as np
from numpy.typing import NDArray

import cdpr

Array = NDArray[np.float64]


class Mine(cdpr.plugins.Controller):
    columns = (cdpr.plugins.Column("load", cdpr.plugins.CABLES, "N", "Load"),)

    def log(self, columns: Mapping[str, Array]) -> None:
        self.load = columns["load"]

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        out[:] = 0.0


def runs(file: str) -> Array:
    try:
        run = cdpr.simulate(file, backend="mujoco", overrides={"simulation.duration": 2.0})
    except cdpr.Infeasible as stop:
        partial: cdpr.Run = stop.run
        run = partial
    assert_type(run, cdpr.Run)
    assert_type(cdpr.load_run("runs/one"), cdpr.Run)
    summary: dict[str, Any] = run.summary()
    print(summary)
    assert_type(run.position, Array)
    assert_type(run["position"], Array)
    return run.tension


def robots(file: str) -> Array:
    robot = cdpr.load_robot(file)
    assert_type(robot, cdpr.Robot)
    quaternion = cdpr.model.rotations.from_rpy(0.1, 0.0, 0.0)
    pose = np.concatenate([[0.0, 0.0, 1.2], quaternion])
    return cdpr.distribute(robot, pose).tension


def built() -> cdpr.Scenario:
    corners = np.zeros((8, 3))
    robot = cdpr.Robot.from_points(corners, 0.1 * corners, mass=20.0)
    other = robot.replace(platform=cdpr.Platform(30.0, [1.0, 1.0, 1.0]), cables=[cdpr.Cable([0, 0, 3], [0, 0, 0])])
    assert_type(other, cdpr.Robot)
    move = cdpr.motions.Quintic(duration=2.0, to=cdpr.motions.Knot(position=(0.0, 0.0, 1.0)))
    push = cdpr.events.Wrench(time=0.5, duration=0.1, force=(100.0, 0.0, 0.0))
    return cdpr.Scenario(robot=other, simulation={"duration": 2.5}, trajectory=move, events=[push])


def analyses(file: str) -> None:
    assert_type(cdpr.load_scenario(file), cdpr.Scenario)
    comparison = cdpr.compare(file, backends=["dart"])
    assert_type(comparison, cdpr.analysis.compare.Comparison)
    assert_type(cdpr.study(file, "out"), cdpr.analysis.study.Results)
    assert_type(cdpr.design(file, "out"), cdpr.analysis.design.Designed)
    assert_type(cdpr.size([file, "runs/one"]), cdpr.analysis.sizing.Sizing)
    assert_type(cdpr.workspace(file, "static", cells=10).volume, float)
    assert_type(cdpr.view(file), Path)
    assert_type(cdpr.export(file, "mjcf"), Path)
    module: ModuleType = cdpr.trajectory
    print(module)


def mistakes() -> None:
    cdpr.simulat("scenario.yaml")  # type: ignore[attr-defined]
    cdpr.tension.distribut  # type: ignore[attr-defined] # noqa: B018
    cdpr.load_run("runs/one").positon  # type: ignore[attr-defined] # noqa: B018
    cdpr.simulate(backend="dart")  # type: ignore[call-arg]
