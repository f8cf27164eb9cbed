"""Preparation of a run from the user's arguments: the scenario with the chosen plugins, and the folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from cdpr.log.run_folder import RunFolder, folder_name
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.registry import Role, registry
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.loader import AnyScenario
from cdpr.simulation.disk_space import check_room
from cdpr.simulation.header import make_header
from cdpr.simulation.runner import Runner


def chosen_scenario(
    scenario: AnyScenario,
    backend: str | type[Backend] | None,
    solver: str | type[TensionSolver] | None,
    controller: str | type[Controller] | None,
    overrides: Mapping[str, Any] | None,
) -> Scenario:
    """Load a scenario with the chosen plugins, given by name or as classes."""
    changes = {} if overrides is None else overrides
    plugins = scenario.plugins if isinstance(scenario, Scenario) else registry()
    names: dict[str, str | None] = {}
    given: dict[Role, object] = {"backend": backend, "solver": solver, "controller": controller}
    for role, choice in given.items():
        if choice is not None and not isinstance(choice, str):
            plugins, choice = plugins.with_class(role, choice)
        names[role] = choice
    if isinstance(scenario, Scenario):
        return scenario.with_changes(changes, **names, plugins=plugins)
    backend, solver, controller = names.values()
    return load_scenario(
        scenario, overrides=changes, backend=backend, solver=solver, controller=controller, plugins=plugins
    )


def attempt(
    scenario: AnyScenario,
    backend: str | type[Backend] | None,
    solver: str | type[TensionSolver] | None,
    controller: str | type[Controller] | None,
    overrides: Mapping[str, Any] | None,
    out: str | os.PathLike[str] | RunFolder | None,
) -> Runner:
    """Load a scenario with the chosen plugins, and make the folder; nothing is built."""
    scenario = chosen_scenario(scenario, backend, solver, controller, overrides)
    as_it_was = not overrides and all(each is None for each in (backend, solver, controller))
    if isinstance(out, RunFolder):
        return Runner(scenario, out.header if as_it_was else make_header(scenario), out)
    header = make_header(scenario)
    path = None if out is None else folder_name(out)
    check_room(scenario, header, path)
    return Runner(scenario, header, None if path is None else RunFolder(path, header, scenario=scenario.yaml_in))
