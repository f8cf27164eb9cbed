"""Winches that take lengths or rates in exports: conversion of their commands, and lengths at the start."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables.tables import command_kinds, line_table
from cdpr.mechanics.attachments import with_attachments
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario
from cdpr.simulation.winding import hold_weight
from cdpr.tension.current_sample import Present
from cdpr.tension.stage import StageSolver, TensionStage
from cdpr.tension.winch_command import chains_of_map


class ExportedWinding:
    """Arrays of the conversion, as in `cdpr/tension/winding.hpp`.

    Attributes:
        unwound: (m,), m, unwound lengths of the plant, NaN before its start.
        command, drive: (m,), commands of the winches, and of their kernels; `drive` begins with the lengths at the
            start.
        arguments: arrays of the operations by name.
        start: (m,), N, tensions at the start.

    Args:
        scenario: scenario.
        lines, state, sensed: lines of the cables, seen state (13,), and seen lengths and rates (2, m), live.
        start, lengths: (m,), N, tensions at the start, and lengths as `start_lengths` returns.
    """

    def __init__(
        self, scenario: Scenario, lines: Array, state: Array, sensed: Array, start: Array, lengths: Array
    ) -> None:
        robot, nominal = scenario.robot, scenario.nominal or scenario.robot
        self.unwound, self.command, self.drive = np.full(robot.m, np.nan), np.zeros(robot.m), np.zeros(robot.m)
        self.arguments: dict[str, Any] = {
            "chains": chains_of_map(robot, nominal),
            "lines": lines,
            "gravity": np.array(scenario.world.gravity, dtype=np.float64),
            "state": state,
            "sensed": sensed,
            "takes": command_kinds(robot),
            "unwound": self.unwound,
            "command": self.command,
            "drive": self.drive,
            "period": scenario.simulation.control_step,
        }
        self.start = start
        self.drive[:] = lengths

    def winds(self, tension: Array) -> Any:
        """Return the operation that converts tensions (m,)."""
        return bind("wind_commands", **self.arguments, tension=tension)


def holding_tensions(scenario: Scenario) -> Array:
    """Return the tensions (m,), N, by which the scenario's solver holds the platform at rest at its initial pose.

    Bodies that events attach at the start are included.
    """
    nominal, robot = scenario.nominal or scenario.robot, scenario.controlled_robot
    gravity = np.array(scenario.world.gravity, dtype=np.float64)
    live = Present.of(robot.m)
    state = np.concatenate([scenario.initial.state()[:7], np.zeros(6)])
    entry = registry().get("solver", scenario.solver.type)
    solver = entry.make(robot, scenario.solver_options)
    respects = bool(entry.info.properties.get("respects_bounds", True))
    stage = TensionStage(robot, StageSolver(solver.solve, scenario.solver.type, respects, "best_effort"), live)
    bind(
        "geometry",
        lines=line_table(nominal),
        state=state,
        matrix=live.W,
        length=np.zeros(robot.m),
        rate=np.zeros(robot.m),
    )()
    step = scenario.simulation.control_step
    spans = (event.attachment(step) for event in scenario.events)
    attached = [span.body for span in spans if span is not None and span.first == 0 < span.end]
    hold_weight(stage, live, with_attachments(scenario.robot, attached), state[:7], gravity)
    return live.tension.copy()


def start_lengths(scenario: Scenario, tension: Array) -> Array:
    """Return the unwound lengths (m,), m, of winches that take lengths or rates, with tensions (m,), N, at the start.

    Those of other winches are their tensions.

    Raises:
        CdprError: if a cable has no such length.
    """
    robot, nominal = scenario.robot, scenario.nominal or scenario.robot
    m, state, lines = robot.m, scenario.initial.state(), line_table(nominal)
    sensed, drive = np.zeros((2, m)), np.zeros(m)
    bind("geometry", lines=lines, state=state, matrix=np.zeros((6, m)), length=sensed[0], rate=sensed[1])()
    bind(
        "wind_commands",
        chains=chains_of_map(robot, nominal),
        lines=lines,
        gravity=np.array(scenario.world.gravity, dtype=np.float64),
        state=state,
        sensed=sensed,
        takes=command_kinds(robot),
        unwound=np.full(m, np.nan),
        command=np.zeros(m),
        drive=drive,
        period=1.0,
        tension=tension,
    )()
    if not np.isfinite(drive).all():
        i = int(np.flatnonzero(~np.isfinite(drive))[0])
        raise CdprError(
            f"cable '{robot.cables[i].name}': no unwound length at the initial pose has the tension {tension[i]:.4g} N "
            "by which the solver holds the platform: raise robot.tension.min"
        )
    return drive
