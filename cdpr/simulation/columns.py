"""Additional columns of a run: those of plugins and of optional features."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cdpr.base.column import Column
from cdpr.base.columns import FIRST, GROUPS, clash
from cdpr.base.errors import CdprError, PluginError
from cdpr.cables import bends, has_drums, has_steppers, rubs, takes_lengths
from cdpr.cables.motor import is_electrical
from cdpr.log.layout import Layout, implied_columns
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.registry import Registered, Role
from cdpr.scenario import Scenario
from cdpr.scenario.events import logged_mass_changes
from cdpr.simulation.loop_part import LoopPart, perceived_differs
from cdpr.simulation.loop_parts import loop_parts

# Conditions of the groups of `cdpr.base.columns.GROUPS`, for a scenario and the parts of its loop; without one, a group
# is that of a part.
CONDITIONS: dict[str, Callable[[Scenario, Sequence[LoopPart]], bool]] = {
    "winched": lambda scenario, parts: not scenario.ideal_cables,
    "friction": lambda scenario, parts: rubs(scenario.robot),
    "drums": lambda scenario, parts: takes_lengths(scenario.robot),
    "motors": lambda scenario, parts: scenario.actuators is None and has_drums(scenario.robot),
    "electrical": lambda scenario, parts: (
        scenario.actuators is None and has_drums(scenario.robot) and is_electrical(scenario.robot)
    ),
    "steppers": lambda scenario, parts: has_steppers(scenario.robot),
    "unstretched": lambda scenario, parts: bends(scenario.robot) or takes_lengths(scenario.robot),
    "sagging": lambda scenario, parts: bends(scenario.robot),
    "later": lambda scenario, parts: True,
    "perceived": lambda scenario, parts: perceived_differs(scenario.nominal, parts),
    "loaded": lambda scenario, parts: logged_mass_changes(scenario.events),
}


def chosen_plugins(scenario: Scenario) -> dict[Role, Registered]:
    """Return the plugins of a scenario, by role.

    Raises:
        PluginError: if one is unknown.
    """
    found = scenario.plugins
    chosen: dict[Role, Registered] = {
        "solver": found.get("solver", scenario.solver.type),
        "controller": found.get("controller", scenario.controller.type),
        "backend": found.get("backend", scenario.simulation.backend),
    }
    if scenario.estimator is not None:
        chosen["estimator"] = found.get("estimator", scenario.estimator.type)
    return chosen


def columns_of(scenario: Scenario) -> tuple[Column, ...]:
    """Return the columns of a run's rows after `cdpr.base.columns.FIRST`.

    Raises:
        PluginError: if two columns have one name, in the log or in an export.
        CdprError: if one of the two is that of a sensor.
    """
    chosen = chosen_plugins(scenario)
    declared = [replace(column, owner=role) for role, entry in chosen.items() for column in entry.info.columns]
    parts = loop_parts(scenario)
    chosen_groups = [name for name in GROUPS if name in CONDITIONS and CONDITIONS[name](scenario, parts)]
    grouped = [column for name in chosen_groups for column in GROUPS[name].columns]
    of_parts = [column for part in parts for column in part.columns]
    more = (*grouped, *of_parts, *declared)
    found = clash((*FIRST, *more), tuple(cable.name for cable in scenario.robot.cables))
    if found is not None:
        of_sensors = {column.name: each.title for each in scenario.sections.sensors for column in each.columns}

        titles: dict[str, str] = {role: f"{role} '{entry.info.name}'" for role, entry in chosen.items()}

        def whose(column: Column) -> str:
            of_run = f"sensor '{of_sensors[column.name]}'" if column.name in of_sensors else "every run"
            return titles.get(column.owner, of_run)

        one, other, word = found
        both = f"column '{other.name}' of {whose(other)} and column '{one.name}' of {whose(one)} would both be '{word}'"
        if any(not each.owner and each.name in of_sensors for each in (one, other)):
            raise CdprError(f"sensors: {both} in a table: choose another name for the sensor")
        raise PluginError(f"{both} in a table: choose another plugin for one of the two, or rename its column")
    return more


def listed(scenario: Scenario) -> tuple[Column, ...]:
    """Return the columns that the header of a log lists; other cable models than the ideal one imply those of cables.

    Raises:
        PluginError: as `columns_of`.
    """
    implied = implied_columns(scenario.cable_model)
    return tuple(column for column in columns_of(scenario) if column not in implied)


def hand_out(layout: Layout, row: Array, plugins: Mapping[str, Backend | Controller | TensionSolver]) -> None:
    """Give each plugin, by role, live views of its columns; made once for the whole run."""
    row[layout.added] = np.nan  # default until a plugin writes
    for role, plugin in plugins.items():
        own = {column.name: row[layout.columns[column.name]] for column in layout.more if column.owner == role}
        if own:
            plugin.log(own)
