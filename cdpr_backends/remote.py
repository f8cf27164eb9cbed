"""Plants in another process, such as a robot's control computer or another simulator: commands out, state in."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from cdpr.base import tolerances
from cdpr.base.errors import BackendDied
from cdpr.cables import immediate
from cdpr.cables.tables import command_kinds
from cdpr.fmu.run.exchange import normaliser
from cdpr.link.peer import Peer, check_peer, greeting_of
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.backend import Operations
from cdpr_backends.remote_winches import MeasuredWinches

START, STEP, STOP = range(3)  # kinds of requests in a message
STATE = 13


class RemoteBackend(Backend):
    """Plant in one peer, which receives the initial state and then the commands, and answers with its state.

    Sent commands are finite, and tensions are within the limits of the robot. Winches that take lengths or rates
    receive these. A plant with winches also answers with the tensions and unwound lengths of its cables. A peer must
    stop safely by itself if it receives no message for its time-out, or if the connection ends. A run sends a stop
    message at its end. The log contains the requested commands. If sent commands differ, for example for a broken
    cable, a warning states this.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self._program = None if options.program is None else options.program.path
        check_peer(options, self._program)
        self._frame = np.zeros(2 + robot.m + 6 + STATE)
        self._winched = None if immediate(robot) else MeasuredWinches(robot, self.state)
        if self._winched is not None:
            self.highest = self._winched.highest
        self._normalise = normaliser(self.state)
        self._peer: Peer | None = None
        self._late = np.full(1, np.nan)
        self._pulled = command_kinds(robot) == 0  # cables whose winch takes a tension
        self._begun, self._due, self._steps, self._missed, self._latest = 0.0, 0.0, 0, 0, 0.0
        self._clipped = 0

    def reset(self, state: Array) -> None:
        """Greet the peer, unless it has not moved since the last greeting, and start it in `state` (13,)."""
        if self._steps:
            self.close()
        if self._peer is None:
            self._peer = self._greeted()
        self._request(START, 0.0, np.asarray(state, dtype=np.float64))
        if self._winched is not None:
            self._winched.begin()
        self._due, self._steps, self._missed, self._latest = 0.0, 0, 0, 0.0
        self._clipped = 0

    def step(self, n: int) -> None:
        """Advance by n physics steps; in real time not before the same wall time has passed."""
        duration = n * self.physics_step
        if self._steps == 0:
            self._begun = time.monotonic()
        self._request(STEP, duration, np.zeros(STATE))
        self._steps += 1
        if self._winched is not None:
            self._winched.moved(duration)
        self._clipped += bool(((self._frame[2 : 2 + self.robot.m] != self.command) & self._pulled).any())
        self._due += duration
        if self.options.real_time:
            ahead = self._begun + self._due - time.monotonic()
            self._late[0] = max(0.0, -ahead)
            if ahead > 0.0:
                time.sleep(ahead)
            elif -ahead > duration:
                self._missed += 1
                self._latest = max(self._latest, -ahead)

    def read_tension(self, tension: Array) -> None:
        """Write the tension of each cable, N, that a plant with winches answered last."""
        if self._winched is None:
            super().read_tension(tension)
        else:
            tension[:] = self._winched.tension

    def cable_work(self) -> float:
        """Return the work of these tensions, J."""
        return super().cable_work() if self._winched is None else self._winched.work

    def winch_readings(self, unwound: Array, unwinding: Array, torque: Array) -> Operations:
        """Return the operation that writes the unwound lengths that the plant answered last, and their rates."""
        if self._winched is None:
            return super().winch_readings(unwound, unwinding, torque)
        return [partial(self._winched.read, unwound, unwinding, torque)]

    def log(self, columns: Mapping[str, Array]) -> None:
        """Store the column of the delay of each step."""
        self._late = columns["step_late"]

    def close(self) -> None:
        """Stop the peer and close the connection; warn of steps that were too late and of limited commands."""
        if self._peer is None:
            return
        self._fill(STOP, 0.0, np.zeros(STATE))
        self._peer.send(self._frame)
        self._peer.close()
        self._peer = None
        if self._missed:
            text = f"{self._missed} of {self._steps} control steps came more than one step too late, by up to"
            warnings.warn(f"real time: {text} {1e3 * self._latest:.3g} ms", stacklevel=2)
        if self._clipped:
            text = "commands beyond the limits of tension were clipped; the log contains the original commands"
            warnings.warn(f"in {self._clipped} of {self._steps} control steps {text}", stacklevel=2)

    def _request(self, kind: int, duration: float, state: Array) -> None:
        assert self._peer is not None
        self._fill(kind, duration, state)
        answer = self._peer.request(self._frame)
        self.state[:] = answer[:STATE]
        if self._winched is not None:
            self._winched.take(answer[STATE:])
        if abs(float(np.linalg.norm(self.state[3:7])) - 1.0) > tolerances.UNIT:
            raise BackendDied(
                f"{self._peer.called}: its quaternion w, x, y, z is {self.state[3:7].tolist()}, whose length is not 1"
            )
        self._normalise()  # single precision has larger rounding errors

    def _fill(self, kind: int, duration: float, state: Array) -> None:
        robot, frame = self.robot, self._frame
        frame[0], frame[1] = kind, duration
        low, high = robot.tension_min, robot.tension_max
        np.clip(np.where(np.isfinite(self.command), self.command, low), low, high, out=frame[2 : 2 + robot.m])
        sent = frame[2 : 2 + robot.m]
        if kind != STEP:
            sent[:] = np.where(self._pulled, low, 0.0)
        elif self._winched is not None:
            sent[~self._pulled] = self._winched.commands(self.command, duration)[~self._pulled]
        frame[2 + robot.m : 8 + robot.m] = self.external
        frame[8 + robot.m :] = state

    def _greeted(self) -> Peer:
        more = {"physics_step": self.physics_step, "real_time": self.options.real_time}
        greeting = greeting_of("plant", self.robot, self.gravity) | more
        takes = STATE if self._winched is None else STATE + 2 * self.robot.m
        return Peer(self.options, self._program, greeting, len(self._frame), takes)
