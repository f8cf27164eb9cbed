"""Power cuts and brakes of the winches of a loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.cables import chain_of
from cdpr.cables.brake import brake_of
from cdpr.mechanics.winches import POWERED
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend


class Brakes:
    """Brakes of the winches of a robot (`cdpr.cables.brake`).

    Attributes:
        torque: (m,), N m, `Backend.brakes`, live; always negative if the backend has none.
        commands: arrays (m,) with the commands of winches, live; cut for cables that do not stretch.
    """

    def __init__(self, robot: Robot, backend: Backend) -> None:
        self._backend, live = backend, backend.brakes
        self.torque = np.full(robot.m, POWERED) if live is None else live
        brakes = ((i, brake_of(each)) for i, each in enumerate(robot.cables) if chain_of(robot, each).stretches)
        self._known = {i: brake for i, brake in brakes if brake is not None}
        self._rigid = [i for i, each in enumerate(robot.cables) if not chain_of(robot, each).stretches]
        self.commands: tuple[Array, ...] = ()

    def __bool__(self) -> bool:
        """Return True if a winch has a brake."""
        return bool(self._known)

    def powered(self) -> bool:
        """Return True if the winches have power."""
        return not bool((self.torque >= 0.0).any())

    def cut(self) -> None:
        """Cut the power of all winches, if any has a brake; without brakes, their commands of tensions become 0."""
        if self._known:
            self.torque[:] = 0.0
            for command in self.commands:
                command[self._rigid] = 0.0

    def closing(self, time: float) -> Iterator[tuple[float, Callable[[], None]]]:
        """Yield the times, s, at which brakes close after a power cut at `time`, and functions that do it.

        Raises:
            PluginError: if the backend does not support brakes.
        """
        if self._known and self._backend.brakes is None:
            raise PluginError(
                f"{type(self._backend).__name__} does not support brakes, which hold the winches without power: choose "
                "another backend, or an emergency stop of category 2"
            )
        for i, (torque, delay) in self._known.items():
            yield time + delay, partial(self._close, i, torque)

    def _close(self, i: int, torque: float) -> None:
        self.torque[i] = torque
