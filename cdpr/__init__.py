"""Simulate and analyse cable-driven parallel robots.

    import cdpr

    run = cdpr.simulate("scenarios/caroca.yaml", overrides={"simulation.duration": 2.0})
    run.time, run.position, run.tension      # arrays, shapes as cdpr.Run says
    run.plot()
    robot = cdpr.load_robot("scenarios/robots/caroca.yaml")
    cdpr.distribute(robot, [0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0]).tension

Everything here is imported when it is first used, so that `import cdpr` stays quick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from cdpr import model, tension
    from cdpr.distribution import admissible, distribute
    from cdpr.errors import CdprError, Diverged, Infeasible, PluginError, ScenarioError, SimulationStopped
    from cdpr.log.reader import load_run
    from cdpr.log.run import Run
    from cdpr.scenario import Scenario, load_robot, load_scenario
    from cdpr.simulation import simulate

_HOME = {
    "CdprError": "cdpr.errors",
    "Diverged": "cdpr.errors",
    "Infeasible": "cdpr.errors",
    "PluginError": "cdpr.errors",
    "Run": "cdpr.log.run",
    "Scenario": "cdpr.scenario",
    "ScenarioError": "cdpr.errors",
    "SimulationStopped": "cdpr.errors",
    "admissible": "cdpr.distribution",
    "distribute": "cdpr.distribution",
    "load_robot": "cdpr.scenario",
    "load_run": "cdpr.log.reader",
    "load_scenario": "cdpr.scenario",
    "simulate": "cdpr.simulation",
}

_ROOMS = ("model", "tension")  # of which users call the functions

__all__ = [
    "CdprError",
    "Diverged",
    "Infeasible",
    "PluginError",
    "Run",
    "Scenario",
    "ScenarioError",
    "SimulationStopped",
    "__version__",
    "admissible",
    "distribute",
    "load_robot",
    "load_run",
    "load_scenario",
    "model",
    "simulate",
    "tension",
]


def __getattr__(name: str) -> object:
    """Import a public name from the room where it lives."""
    from importlib import import_module

    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    if name in _ROOMS:
        return import_module(f"cdpr.{name}")
    raise AttributeError(f"module 'cdpr' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
