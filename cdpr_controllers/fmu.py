"""A controller that comes as an FMU, such as one built in Simulink.

At each call the FMU is given the state and the desired state, which it holds while it does one step of the length of a
control step; what it puts out then is the output of this call. So a controller with a sample time of its own computes
from the present state, and its integrals advance as they should; only a clock of its own runs one step ahead.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from cdpr.errors import PluginError
from cdpr.fmu.archive import open_archive
from cdpr.fmu.exchange import DESIRED, STATE, reader, writer
from cdpr.fmu.mapping import map_signals
from cdpr.fmu.parameters import Parameters
from cdpr.fmu.running import run_fmu
from cdpr.fmu.trust import require_trust
from cdpr.model import Robot, kinematics
from cdpr.model.kernels import cable_geometry
from cdpr.model.robot import Array
from cdpr.plugins import Controller
from cdpr.plugins.controller import Output


class FmuController(Controller):
    """One FMU with the state as inputs and a wrench or the commands as outputs.

    Attributes:
        mapping: which of its variables are which signals.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        archive = open_archive(options.path(options.file))
        require_trust(archive, options.sha256)
        self.mapping = map_signals(archive.description, robot, options.signals, "controller")
        self._parameters = Parameters(archive.description)
        if options.from_robot:
            for name, value, unit in known_parameters(robot, gravity)
    
