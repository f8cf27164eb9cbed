"""Winches of a plant that is an FMU: commands in the units of the FMU, and its readings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cdpr.base.errors import FmuError
from cdpr.cables import RATE, TENSION, bends, chain_of, commands_of, takes_lengths
from cdpr.cables.drums import drum_table
from cdpr.cables.tables import reached_by_rate
from cdpr.fmu.run.exchange import reader, writer
from cdpr.fmu.run.parameters import Known
from cdpr.fmu.run.running import RunningFmu
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind

INITIAL_LENGTH = "initial_unstretched_length"  # parameter


class FmuWinches:
    """Winches and spans of an FMU.

    The FMU takes what the winches of the robot take. The command of an ideal drive is a rate, from which this class
    computes the lengths at the ends of the communication steps.

    Args:
        robot: robot.
        fmu: running FMU.
        step: communication step, s.

    Attributes:
        highest: (m,), N, largest magnitude of each tension that was read.
        arrays: memory besides that of the FMU.

    Raises:
        FmuError: if the FMU lacks outputs or the parameter for the lengths at the start.
    """

    def __init__(self, robot: Robot, fmu: RunningFmu, step: float) -> None:
        m, self._step, self._instance = robot.m, step, fmu.instance
        takes = commands_of(robot)
        self._lengths = np.array([each != TENSION for each in takes])
        self._rates = np.array([each == RATE for each in takes])
        self._by_rate = reached_by_rate(robot)
        _check(robot, fmu)
        inputs, outputs, values = fmu.mapping.inputs, fmu.mapping.outputs, fmu.instance.outputs
        self._write = writer(inputs, {"command": 0}, fmu.instance.inputs)
        self._tension, self._work = np.zeros(m), np.zeros(1)
        self._unwound, self._unwinding, self._torque = np.zeros(m), np.zeros(m), np.full(m, np.nan)
        self._bending = np.zeros(6)
        # Drums of cables that do not stretch follow these: such an FMU has no unstretched lengths.
        unwound = "unstretched" if any(chain_of(robot, cable).stretches for cable in robot.cables) else "cable"
        self._readers = [
            reader(outputs, {name: 0}, values, out)
            for name, out in (
                ("cable_tension", self._tension),
                ("cable_work", self._work),
                (f"{unwound}_length", self._unwound),
                (f"{unwound}_rate", self._unwinding),
                ("motor_torque", self._torque),
                ("bending_wrench", self._bending),
            )
            if name in outputs.ports
        ]
        self._reads_drums = {f"{unwound}_length", f"{unwound}_rate"} <= set(outputs.ports)
        self._turned = {name: np.zeros((1, m)) for name in ("angle", "per_turn", "speed", "turning", "load")}
        given = {"unwound": self._unwound[None], "rate": self._unwinding[None], "acceleration": np.zeros((1, m))}
        self._turn = bind("drum_motions", drums=drum_table(robot), **given, **self._turned)
        self._begun = np.zeros(1)
        self.highest = np.zeros(m)
        self.arrays = self._begun, self.highest

    def reset(self) -> None:
        """Wait for the first command again."""
        self._begun[:], self.highest[:] = not self._lengths.any(), 0.0

    def put(self, command: Array, restart: Callable[[dict[str, Known]], None]) -> None:
        """Write the commands (m,) of the backend into the FMU; the first ones are its lengths at the start."""
        if not self._begun[0]:
            self._write(np.where(self._rates, 0.0, command))
            restart({INITIAL_LENGTH: (np.where(self._lengths, command, 0.0), "m")})
            self._begun[:] = 1.0
        self._get()
        self._write(self._after(1, command))

    def step(self, n: int, command: Array) -> None:
        """Advance the FMU by n communication steps."""
        if self._by_rate.any():
            self._get()
            ways = [self._after(k, command) for k in range(1, n + 1)]
            for way in ways:
                self._write(way)
                self._instance.step(1)
        else:
            self._instance.step(n)
        self._get()
        np.maximum(self.highest, np.abs(self._tension), out=self.highest)

    def read_tension(self, command: Array, tension: Array) -> None:
        """Write the tensions (m,), N, under the present command."""
        self._instance.refresh()
        self._get()
        tension[:] = self._tension
        np.maximum(self.highest, np.abs(tension), out=self.highest)

    def read(self, unwound: Array, unwinding: Array, torque: Array) -> None:
        """Write unwound lengths, their rates, and torques of the motors; NaN before the start."""
        self._get()
        unwound[:] = self._unwound if self._begun[0] else np.nan
        unwinding[:], torque[:] = self._unwinding, self._torque

    def read_drums(self, angle: Array, speed: Array, torque: Array, power: Array) -> None:
        """Write angles and speeds of the drums, torques and powers of the motors; NaN if the FMU lacks outputs."""
        if not self._reads_drums:
            return
        self._get()
        self._turn()
        angle[:], speed[:] = self._turned["angle"][0], self._turned["speed"][0]
        torque[:], power[:] = self._torque, self._torque * speed

    def read_bending(self, unstretched: Array, bending: Array) -> None:
        """Write unstretched lengths, and the wrench of bending."""
        self._get()
        unstretched[:], bending[:] = self._unwound, self._bending

    def work(self) -> float:
        """Return the work of the cables on the platform, J."""
        self._get()
        return float(self._work[0])

    def _after(self, k: int, command: Array) -> Array:
        """Return the inputs after k communication steps: of ideal drives with lengths, those that they reach."""
        return np.where(self._by_rate, self._unwound + command * (k * self._step), command)

    def _get(self) -> None:
        for read in self._readers:
            read()


def _check(robot: Robot, fmu: RunningFmu) -> None:
    """Raise FmuError if the FMU lacks a variable that such a robot requires."""
    needed = ["cable_tension", "cable_work"]
    if takes_lengths(robot):
        needed += ["unstretched_length", "unstretched_rate"]
    if bends(robot):
        needed += ["unstretched_length", "bending_wrench"]
    lacking = [name for name in dict.fromkeys(needed) if name not in fmu.mapping.outputs.ports]
    if lacking:
        raise FmuError(
            f"the FMU '{fmu.name}' has no output {', '.join(lacking)}, which a robot with winches requires: export it "
            "with --with-winch, or set robot.cable.model to ideal"
        )
    if takes_lengths(robot) and fmu.archive.description.by_name.get(INITIAL_LENGTH) is None:
        named = [name for name in fmu.archive.description.by_name if name.startswith(INITIAL_LENGTH)]
        if not named:
            raise FmuError(
                f"the FMU '{fmu.name}' has no parameter {INITIAL_LENGTH}, which winches that take lengths or rates "
                "require"
            )
