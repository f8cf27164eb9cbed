"""Winches that take lengths or rates as their commands: conversion of tensions, and their columns."""

from __future__ import annotations

import numpy as np

from cdpr.cables import RATE, commands_of, takes_lengths
from cdpr.cables.tables import command_kinds
from cdpr.mechanics.dynamics import required_wrench
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.simulation.brakes import Brakes
from cdpr.simulation.parts import Parts
from cdpr.simulation.sample import Sample
from cdpr.simulation.steppers import Steppers
from cdpr.tension.command import CommandStage
from cdpr.tension.current_sample import Present
from cdpr.tension.operations import Operation
from cdpr.tension.stage import TensionStage
from cdpr.tension.winch_command import WinchStage, chains_of_map

Stage = TensionStage | CommandStage


class Winding:
    """Commands of the winches of a loop; none if all take tensions.

    The map from a tension to an unwound length is that of the nominal robot's spans at the state that the controller
    sees; the winches are the true ones. An ideal drive winds at the rate that reaches a length at the end of the
    control period.

    Attributes:
        drive: (m,), commands of the plant, live: the tensions that drives apply, if all winches take tensions.
        brakes: brakes of the winches.
        start: (m,), N, tensions before the start of winches that take rates from the controller.
    """

    def __init__(self, parts: Parts, present: Sample) -> None:
        self._parts, self._present = parts, present
        self._active = takes_lengths(parts.robot)
        self.brakes = Brakes(parts.robot, parts.backend)
        self.start = np.zeros(parts.robot.m)
        self._reading: list[Operation] = []
        self._placing: list[Operation] = []
        self._applying = [each for part in parts.more for each in part.commanded()]
        self.drive = present.drive
        if not self._active:
            return
        robot, view = parts.perceived_robot, present.view
        self.command, unwound = view("winch_command"), view("unstretched_length")
        chains = chains_of_map(parts.robot, robot)
        lines, self._placing = present.placed_lines(robot)
        cables = {"chains": chains, "lines": lines, "gravity": parts.backend.gravity}
        cables |= {"state": present.seen, "sensed": present.seen_cables}
        takes = command_kinds(parts.robot)
        drives = {"takes": takes, "unwound": unwound, "command": self.command, "drive": self.drive}
        self._given = {**cables, **drives, "period": parts.control_step}
        torque = view("motor_torque") if present.layout.has("motors") else np.empty(parts.robot.m)
        readings = parts.backend.winch_readings(unwound, view("unstretched_rate"), torque)
        self._reading = [Operation("backend", do) for do in readings]
        wind = bind("wind_commands", **self._given, tension=present.live.tension)
        self._wind = Operation("distribution", wind, telling=True)
        if present.layout.has("driven"):
            driven = bind("drive_winches", **self._given, applied=view("drive_command"))
            self._applying.append(Operation("drives", driven, telling=True))
        given = view("drive_command") if present.layout.has("driven") else self.command
        self._steppers = Steppers(parts, present, self.brakes.torque, given, self.drive)
        self.brakes.commands = self.command, self.drive

    def stage(self) -> WinchStage:
        """Return the stage for commands of the winches."""
        parts, present = self._parts, self._present
        given = {**self._given, "start": self.start}
        return WinchStage(parts.controlled_robot, parts.policy, present.live, present.cables, given)

    def reading(self) -> list[Operation]:
        """Return the operations before a stage, which read the winches."""
        return [*self._placing, *self._reading, *(self._steppers.counting if self._active else ())]

    def commanding(self, stage: Stage) -> list[Operation]:
        """Return the operations after a stage, which write the commands of the winches and apply them."""
        winding = [self._wind] if self._active and not isinstance(stage, WinchStage) else []
        if self.brakes:  # without power, commands do not change
            winding = [each._replace(when=self.brakes.powered) for each in winding]
        return [*winding, *self._applying, *(self._steppers.issuing if self._active else ())]

    def starting(self, stage: Stage) -> list[Operation]:
        """Return the operations after the plant has evaluated its cables.

        At the first sample this starts the winches. Before that, the command of an ideal drive was its length.
        """
        if not self._active:
            return []
        winding = stage.operations if isinstance(stage, WinchStage) else [self._wind]
        starting = [each._replace(telling=False) for each in (*winding, *self._applying, *self._steppers.issuing)]
        return [*self._reading, self._only_at_start(len(starting)), *starting]

    def _only_at_start(self, count: int) -> Operation:
        """Return the operation that skips this number of following ones, except at the first sample."""
        later = bind("later_sample", time=self._present.view("time"))
        handled = bind("not_finite", values=np.zeros(1))  # returns 0
        return Operation("distribution", later, lambda _: None, skip=count, mend=handled)

    @property
    def needs_start(self) -> bool:
        """True if `start` is used: the controller commands rates, which define no tension."""
        return self._parts.output == "winch" and RATE in commands_of(self._parts.robot)

    def hold(self, stage: Stage) -> None:
        """Write into `start` the tensions by which a stage holds the weight of the plant, with its payload, at rest."""
        backend = self._parts.backend
        hold_weight(stage, self._present.live, backend.robot, self._present.seen[:7], backend.gravity)
        self.start[:] = self._present.live.tension


def hold_weight(stage: Stage, live: Present, robot: Robot, pose: Array, gravity: Array) -> None:
    """Write into `live` the tensions by which a stage holds the weight of a robot at rest.

    Args:
        stage: stage that takes wrenches and reads `live`.
        live: current sample, with the wrench matrix at the pose.
        robot: robot with that weight.
        pose: (7,) position, m, and quaternion.
        gravity: (3,) m/s^2, world.
    """
    live.wrench[:] = required_wrench(robot, np.concatenate([pose, np.zeros(6)]), gravity)
    stage.distribute()
