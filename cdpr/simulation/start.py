"""Preparation of a run from the user's arguments: the scenario with the chosen plugins, and the folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from cdpr.log.run_folder import RunFolder, folder_name
from cdpr.plugins import Backend, Controller, Estimator, TensionSolver
from cdpr.plugins.registry import Role, registry
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.loader import AnyScenario
from cdpr.simulation.disk_space import check_room
from cdpr.simulation.header import make_header
from cdpr.simulation.runner import Runner

# Plugins that replace those of a scenario, by name or as classes; None keeps that of the scenario.
Chosen = Mapping[Role, str | type[Backend] | type[TensionSolver] | type[Controller] | type[Estimator] | None]


def chosen_scenario(scenario: AnyScenario, chosen: Chosen, overrides: Mapping[str, Any] | None) -> Scenario:
    """Load a scenario with the chosen plugins."""
    plugins = scenario.plugins if isinstance(scenario, Scenario) else registry()
    names: dict[str, Any] = {}
    for role, choice in chosen.items():
        names[role] = choice
        if choice is not None and not isinstance(choice, str):
            plugins, names[role] = plugins.with_class(role, choice)
    changes = {} if overrides is None else overrides
    return load_scenario(scenario, overrides=changes, **names, plugins=plugins)


def attempt(
    scenario: AnyScenario,
    chosen: Chosen,
    overrides: Mapping[str, Any] | None,
    out: str | os.PathLike[str] | RunFolder | None,
) -> Runner:
    """Load a scenario with the chosen plugins, and make the folder; nothing is built."""
    scenario = chosen_scenario(scenario, chosen, overrides)
    as_it_was = not overrides and all(each is None for each in chosen.values())
    if isinstance(out, RunFolder):
        return Runner(scenario, out.header if as_it_was else make_header(scenario), out)
    header = make_header(scenario)
    path = None if out is None else folder_name(out)
    check_room(scenario, header, path)
    return Runner(scenario, header, None if path is None else RunFolder(path, header, scenario=scenario.yaml_in))
