"""Controllers in another process, which receive the inputs of a controller and answer with its output."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.link.peer import Peer, check_peer, greeting_of
from cdpr.mechanics.cable_geometry import cable_geometry
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Controller

STATE, DESIRED = 13, 19


class RemoteController(Controller):
    """Controller in one peer, which answers each frame with a wrench or a value for each cable.

    A frame contains time, states, lengths and rates. In lock-step, each call waits for the answer to it. A free-running
    peer receives messages as fast as it can take them, and its latest answer is used.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        self.output = options.quantity
        self._frame = np.zeros(1 + STATE + DESIRED + 2 * robot.m)
        self._lines = line_table(robot)
        self._sensed: Array | None = None
        self._peer: Peer | None = None
        self._program = None if options.program is None else options.program.path
        check_peer(options, self._program)

    def sense(self, cables: Array) -> None:
        """Send the true lengths and rates at the cables, even if the controller's model of the robot differs."""
        self._sensed = cables

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the wrench (6,) or the values of the cables (m,)."""
        if self._peer is None:
            self._peer = self._greeted()
        frame, m = self._frame, self.robot.m
        frame[0] = time
        frame[1 : 1 + STATE] = state
        frame[1 + STATE : 1 + STATE + DESIRED] = desired
        if self._sensed is None:
            _, length, rate = cable_geometry(self._lines, state)
            frame[-2 * m : -m], frame[-m:] = length, rate
        else:
            frame[-2 * m : -m], frame[-m:] = self._sensed
        out[:] = self._peer.request(frame) if self.options.lockstep else self._peer.newest(frame)

    def reset(self) -> None:
        """Close the connection, so that the next call starts a new one."""
        self.close()

    def close(self) -> None:
        """Close the connection to the peer."""
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def _greeted(self) -> Peer:
        robot, output = self.robot, self.options.output
        more = {"output": output, "control_step": self.control_step}
        greeting = greeting_of("controller", robot, self.gravity) | more
        takes = 6 if output == "wrench" else robot.m
        return Peer(self.options, self._program, greeting, len(self._frame), takes)
