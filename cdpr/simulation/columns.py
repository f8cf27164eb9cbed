"""Additional columns of a run: those of plugins and of optional features."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cdpr.base.columns import FIRST, LATER, LOADED, NOMINAL_COLUMNS, WINCHED, Column, clash
from cdpr.base.errors import PluginError
from cdpr.log.layout import Layout
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.registry import Registered, Role
from cdpr.scenario import Scenario
from cdpr.scenario.events import mass_changes
from cdpr.simulation.loop_part import perceived_differs
from cdpr.simulation.loop_parts import loop_parts


def chosen_plugins(scenario: Scenario) -> dict[Role, Registered]:
    """Return the plugins of a scenario, by role.

    Raises:
        PluginError: if one is unknown.
    """
    found = scenario.plugins
    return {
        "solver": found.get("solver", scenario.solver.type),
        "controller": found.get("controller", scenario.controller.type),
        "backend": found.get("backend", scenario.simulation.backend),
    }


def columns_of(scenario: Scenario) -> tuple[Column, ...]:
    """Return the columns of a run's rows after `cdpr.base.columns.FIRST`.

    Raises:
        PluginError: if two columns have one name, in the log or in an export.
    """
    chosen = chosen_plugins(scenario)
    declared = [replace(column, owner=role) for role, entry in chosen.items() for column in entry.info.columns]
    first = FIRST if scenario.ideal_cables else FIRST + WINCHED
    parts = loop_parts(scenario)
    nominal = NOMINAL_COLUMNS if perceived_differs(scenario.nominal, parts) else ()
    loaded = LOADED if mass_changes(scenario.events) else ()
    of_parts = [column for part in parts for column in part.columns]
    more = (*LATER, *nominal, *loaded, *of_parts, *declared)
    found = clash((*first, *more), tuple(cable.name for cable in scenario.robot.cables))
    if found is not None:
        titles: dict[str, str] = {
            "": "every run",
            **{role: f"{role} '{entry.info.name}'" for role, entry in chosen.items()},
        }
        one, other, word = found
        raise PluginError(
            f"column '{other.name}' of {titles[other.owner]} and column '{one.name}' of {titles[one.owner]} would both "
            f"be '{word}' in a table: choose another plugin for one of the two, or rename its column"
        )
    return more


def hand_out(layout: Layout, row: Array, plugins: Mapping[str, Backend | Controller | TensionSolver]) -> None:
    """Give each plugin, by role, live views of its columns; made once for the whole run."""
    row[layout.added] = np.nan  # default until a plugin writes
    for role, plugin in plugins.items():
        own = {column.name: row[layout.columns[column.name]] for column in layout.more if column.owner == role}
        if own:
            plugin.log(own)
