"""Simulation and analysis of cable-driven parallel robots.

    import cdpr

    run = cdpr.simulate("scenarios/caroca.yaml", overrides={"simulation.duration": 2.0})
    run.time, run.position, run.tension      # arrays, shapes as documented in cdpr.Run
    run.plot()
    robot = cdpr.load_robot("scenarios/robots/caroca.yaml")
    cdpr.distribute(robot, [0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0]).tension

All names are imported when first used, so that `import cdpr` is fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

__version__ = "0.1.0"

_HOME = {
    "BackendDied": "cdpr.errors",
    "Batch": "cdpr.rollouts.batch",
    "BeyondLimits": "cdpr.errors",
    "CdprError": "cdpr.errors",
    "Diverged": "cdpr.errors",
    "FmuError": "cdpr.errors",
    "FormatError": "cdpr.errors",
    "Infeasible": "cdpr.errors",
    "Interrupted": "cdpr.errors",
    "LogError": "cdpr.errors",
    "OutputError": "cdpr.errors",
    "PlantEnded": "cdpr.errors",
    "PluginError": "cdpr.errors",
    "Robot": "cdpr.model.robot",
    "Run": "cdpr.log.run",
    "Scenario": "cdpr.scenario",
    "ScenarioError": "cdpr.errors",
    "Simulation": "cdpr.simulation",
    "SimulationStopped": "cdpr.errors",
    "Touched": "cdpr.errors",
    "Unanswered": "cdpr.errors",
    "admissible": "cdpr.distribution",
    "compare_scenario": "cdpr.compare.job",
    "distribute": "cdpr.distribution",
    "get_include": "cdpr.native",
    "load_design": "cdpr.design",
    "load_robot": "cdpr.scenario",
    "load_run": "cdpr.log.reader",
    "load_scenario": "cdpr.scenario",
    "load_study": "cdpr.study",
    "rollout": "cdpr.rollouts.rollout",
    "run_design": "cdpr.design",
    "run_study": "cdpr.study",
    "simulate": "cdpr.simulation",
}

__all__ = [
    "BackendDied",
    "Batch",
    "BeyondLimits",
    "CdprError",
    "Diverged",
    "FmuError",
    "FormatError",
    "Infeasible",
    "Interrupted",
    "LogError",
    "OutputError",
    "PlantEnded",
    "PluginError",
    "Robot",
    "Run",
    "Scenario",
    "ScenarioError",
    "Simulation",
    "SimulationStopped",
    "Touched",
    "Unanswered",
    "__version__",
    "admissible",
    "bench",
    "compare",
    "compare_scenario",
    "design",
    "distribute",
    "errors",
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
    "study",
    "tension",
    "testing",
    "trajectory",
]

if TYPE_CHECKING:
    from cdpr import bench, compare, design, errors, mechanics, model, plugins, study, tension, testing, trajectory
    from cdpr.compare.job import compare_scenario
    from cdpr.design import load_design, run_design
    from cdpr.distribution import admissible, distribute
    from cdpr.errors import (
        BackendDied,
        BeyondLimits,
        CdprError,
        Diverged,
        FmuError,
        FormatError,
        Infeasible,
        Interrupted,
        LogError,
        OutputError,
        PlantEnded,
        PluginError,
        ScenarioError,
        SimulationStopped,
        Touched,
        Unanswered,
    )
    from cdpr.log.reader import load_run
    from cdpr.log.run import Run
    from cdpr.model import Robot
    from cdpr.native import get_include
    from cdpr.rollouts.batch import Batch
    from cdpr.rollouts.rollout import rollout
    from cdpr.scenario import Scenario, load_robot, load_scenario
    from cdpr.simulation.simulate import simulate  # the package also has a module of that name
    from cdpr.simulation.simulation import Simulation
    from cdpr.study import load_study, run_study
else:
    from cdpr.lazy import lazily

    __getattr__ = lazily(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
