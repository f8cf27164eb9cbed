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

`simulate`, `rollout`, `distribute`, `admissible`, `equilibrium`, `equilibria`, `compensated_lengths`, `workspace`,
`size`, `design`, `study`, `compare`, `view` and `export` accept an object, a file, the name of an example, or a dict
with the keys of a file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.base.version import VERSION as __version__  # noqa: N811 - as in other packages

_HOME = {
    "BackendDied": "cdpr.base.errors",
    "Batch": "cdpr.analysis.rollouts.batch",
    "Cable": "cdpr.model.cable",
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
    "Platform": "cdpr.model.platform",
    "PluginError": "cdpr.base.errors",
    "Robot": "cdpr.model.robot",
    "Run": "cdpr.log.run",
    "Scenario": "cdpr.scenario.scenario",
    "ScenarioError": "cdpr.base.errors",
    "Simulation": "cdpr.simulation.simulation",
    "SimulationStopped": "cdpr.base.errors",
    "SolverFailed": "cdpr.base.errors",
    "admissible": "cdpr.analysis.distribution",
    "compare": "cdpr.analysis.verbs",
    "compensated_lengths": "cdpr.analysis.equilibrium",
    "design": "cdpr.analysis.verbs",
    "distribute": "cdpr.analysis.distribution",
    "equilibria": "cdpr.analysis.equilibrium",
    "equilibrium": "cdpr.analysis.equilibrium",
    "events": "cdpr.scenario",
    "export": "cdpr.formats.write.export",
    "get_include": "cdpr.native",
    "import_file": "cdpr.formats.read.import_files",
    "load_robot": "cdpr.scenario.loader",
    "load_run": "cdpr.log.reader",
    "load_scenario": "cdpr.scenario.loader",
    "motions": "cdpr.scenario",
    "rollout": "cdpr.analysis.rollouts.rollout",
    "simulate": "cdpr.simulation.whole_run",
    "size": "cdpr.analysis.verbs",
    "study": "cdpr.analysis.verbs",
    "view": "cdpr.ui.report.view",
    "workspace": "cdpr.analysis.workspace.result",
}

__all__ = [
    "BackendDied",
    "Batch",
    "Cable",
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
    "Platform",
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
    "compare",
    "compensated_lengths",
    "design",
    "distribute",
    "equilibria",
    "equilibrium",
    "events",
    "export",
    "get_include",
    "import_file",
    "load_robot",
    "load_run",
    "load_scenario",
    "mechanics",
    "model",
    "motions",
    "plugins",
    "rollout",
    "sensing",
    "simulate",
    "size",
    "study",
    "tension",
    "testing",
    "trajectory",
    "view",
    "workspace",
]

if TYPE_CHECKING:
    from cdpr import analysis, mechanics, model, plugins, sensing, tension, testing, trajectory
    from cdpr.analysis.distribution import admissible, distribute
    from cdpr.analysis.equilibrium import compensated_lengths, equilibria, equilibrium
    from cdpr.analysis.rollouts.batch import Batch
    from cdpr.analysis.rollouts.rollout import rollout
    from cdpr.analysis.verbs import compare, design, size, study
    from cdpr.analysis.workspace.result import workspace
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
    from cdpr.formats.read.import_files import import_file
    from cdpr.formats.write.export import export
    from cdpr.log.reader import load_run
    from cdpr.log.run import Run
    from cdpr.model import Cable, Platform, Robot
    from cdpr.native import get_include
    from cdpr.scenario import Scenario, events, load_robot, load_scenario, motions
    from cdpr.simulation.simulation import Simulation
    from cdpr.simulation.whole_run import simulate
    from cdpr.ui.report.view import view
else:
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
