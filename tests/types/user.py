"""A user's file: mypy must know the type of everything public, and refuse what does not exist. See test_types.py."""

from __future__ import annotations

from collections.abc import Mapping
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


def analyses(file: str) -> None:
    assert_type(cdpr.load_scenario(file), cdpr.Scenario)
    comparison = cdpr.compare_scenario(file, backends=["dart"])
    assert_type(comparison, cdpr.analysis.compare.Comparison)
    study = cdpr.load_study(file)
    assert_type(study, cdpr.analysis.study.Study)
    module: ModuleType = cdpr.trajectory
    print(module)


def mistakes() -> None:
    cdpr.simulat("scenario.yaml")  # type: ignore[attr-defined]
    cdpr.tension.distribut  # type: ignore[attr-defined] # noqa: B018
    cdpr.load_run("runs/one").positon  # type: ignore[attr-defined] # noqa: B018
    cdpr.simulate(backend="dart")  # type: ignore[call-arg]
