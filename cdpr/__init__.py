"""Simulation and analysis of cable-driven parallel robots.

All names are imported when first used, so that `import cdpr` is fast.

Example:
    >>> import cdpr
    >>> run = cdpr.simulate("caroca", overrides={"simulation.duration": 0.1})
    >>> run.time.shape, run.position.shape, run.tension.shape
    ((101,), (101, 3), (101, 8))
    >>> robot = cdpr.load_robot("caroca")
    >>> cdpr.distribute(robot, robot.home).status
    <Status.OK: 0>
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.base.version import VERSION as __version__  # noqa: N811 - as in other packages

_HOME = {
    "BackendDied": "cdpr.base.errors",
    "Batch": "cdpr.analysis.rollouts.batch",
    "CdprError": "cdpr.base.errors",
    "CollisionDetected": "cdpr.base.errors",
    "Diverged": "cdpr.base.errors",
    "FmuError": "cdpr.base.errors",
    "FormatError": "cdpr.base.errors",
    "Infeasible": "cdpr.base.errors",
    "Interrupted": "cdpr.base.errors",
    "LimitViolation": "cdpr.base.errors",
    "LogError": "cdpr.base.errors",
    "MissingPackageError": "cdpr.base.errors",
    "OutputError": "cdpr.base.errors",
    "PlantEnded": "cdpr.base.errors",
    "PluginError": "cdpr.base.errors",
    "Robot": "cdpr.model.robot",
    "Run": "cdpr.log.run",
    "Scenario": "cdpr.scenario.scenario",
    "ScenarioError": "cdpr.base.errors",
    "Simulation": "cdpr.simulation.simulation",
    "SimulationStopped": "cdpr.base.errors",
    "SolverFailed": "cdpr.base.errors",
    "admissible": "cdpr.analysis.distribution",
    "compare_scenario": "cdpr.analysis.compare.job",
    "distribute": "cdpr.analysis.distribution",
    "get_include": "cdpr.native",
    "load_design": "cdpr.analysis.design",
    "load_robot": "cdpr.scenario.loader",
    "load_run": "cdpr.log.reader",
    "load_scenario": "cdpr.scenario.loader",
    "load_study": "cdpr.analysis.study",
    "rollout": "cdpr.analysis.rollouts.rollout",
    "run_design": "cdpr.analysis.design",
    "run_study": "cdpr.analysis.study",
    "simulate": "cdpr.simulation.whole_run",
}

__all__ = [
    "BackendDied",
    "Batch",
    "CdprError",
    "CollisionDetected",
    "Diverged",
    "FmuError",
    "FormatError",
    "Infeasible",
    "Interrupted",
    "LimitViolation",
    "LogError",
    "MissingPackageError",
    "OutputError",
    "PlantEnded",
    "PluginError",
    "Robot",
    "Run",
    "Scenario",
    "ScenarioError",
    "Simulation",
    "SimulationStopped",
    "SolverFailed",
    "__version__",
    "admissible",
    "analysis",
    "compare_scenario",
    "distribute",
    "get_include",
    "load_design",
    "load_robot",
    "load_run",
    "load_scenario",
    "load_study",
    "mechanics",
    "model",
    "plugins",
    "rollout",
    "run_design",
    "run_study",
    "simulate",
    "tension",
    "testing",
    "trajectory",
]

if TYPE_CHECKING:
    from cdpr import analysis, mechanics, model, plugins, tension, testing, trajectory
    from cdpr.analysis.compare.job import compare_scenario
    from cdpr.analysis.design import load_design, run_design
    from cdpr.analysis.distribution import admissible, distribute
    from cdpr.analysis.rollouts.batch import Batch
    from cdpr.analysis.rollouts.rollout import rollout
    from cdpr.analysis.study import load_study, run_study
    from cdpr.base.errors import (
        BackendDied,
        CdprError,
        CollisionDetected,
        Diverged,
        FmuError,
        FormatError,
        Infeasible,
        Interrupted,
        LimitViolation,
        LogError,
        MissingPackageError,
        OutputError,
        PlantEnded,
        PluginError,
        ScenarioError,
        SimulationStopped,
        SolverFailed,
    )
    from cdpr.log.reader import load_run
    from cdpr.log.run import Run
    from cdpr.model import Robot
    from cdpr.native import get_include
    from cdpr.scenario import Scenario, load_robot, load_scenario
    from cdpr.simulation.simulation import Simulation
    from cdpr.simulation.whole_run import simulate
else:
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
