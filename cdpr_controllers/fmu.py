"""Controllers from FMUs, for example built in Simulink.

At each call, the FMU gets the state and the desired state and holds them for one control step. Its outputs at the end
of the step are the output of the call. So a controller with its own sample time uses the current state, and its
integrals advance correctly. Only its internal clock is one control step ahead.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.trust import require_trust
from cdpr.fmu.run.exchange import DESIRED, STATE, reader, writer
from cdpr.fmu.run.parameters import Known, robot_parameters
from cdpr.fmu.run.running import RunningFmu
from cdpr.mechanics import kinematics
from cdpr.mechanics.cable_geometry import cable_geometry
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Controller


class FmuController(Controller):
    """Controller from one FMU with the state as inputs and a wrench or tensions (signal `command`, N) as outputs.

    Attributes:
        fmu: file, mapping and instance.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        archive = open_archive(options.file.path)
        require_trust(archive, options.sha256)
        self.fmu = RunningFmu(archive, options.file, "controller", robot, control_step, options, "process")
        self._instance = self.fmu.instance
        inputs, outputs = self.fmu.mapping.inputs, self.fmu.mapping.outputs
        signal = "wrench" if "wrench" in outputs.ports else "command"
        self.output = "wrench" if signal == "wrench" else "tension"
        values = self._instance.inputs
        self._put_state, self._put_desired = writer(inputs, STATE, values), writer(inputs, DESIRED, values)
        self._put_length = writer(inputs, {"cable_length": 0}, values)
        self._put_rate = writer(inputs, {"cable_rate": 0}, values)
        self._asks_cables = bool({"cable_length", "cable_rate"} & set(inputs.ports))
        self._lines = line_table(robot)
        self._sensed: Array | None = None
        self._out = np.zeros(6 if self.output == "wrench" else robot.m)
        self._read = reader(outputs, {signal: 0}, self._instance.outputs, self._out)
        self.reset()

    def sense(self, cables: Array) -> None:
        """Use the true lengths and rates at the cables, even if the controller's model of the robot differs."""
        self._sensed = cables

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the wrench (6,) or the tensions (m,)."""
        self._put_state(state)
        self._put_desired(desired)
        if self._asks_cables:
            length, rate = self._sensed.copy() if self._sensed is not None else cable_geometry(self._lines, state)[1:]
            self._put_length(length)
            self._put_rate(rate)
        self._instance.step(1)
        self._read()
        out[:] = self._out

    def reset(self) -> None:
        """Restart the FMU."""
        known: dict[str, Known] = {"control_step": (self.control_step, "s")}
        if self.options.from_robot:
            order = self.options.signals.cable_order
            state = kinematics.make_state(np.zeros(3))
            known |= robot_parameters(self.robot, self.gravity, self.control_step, state, order)
        self._instance.inputs[:] = self.fmu.mapping.inputs.start()
        self.fmu.start(known)

    def describe(self) -> dict[str, Any]:
        """Return the file, the checksum, the mapping and the parameters."""
        return self.fmu.describe()

    def close(self) -> None:
        """Stop the FMU and its process, and delete its folder."""
        self.fmu.close()
