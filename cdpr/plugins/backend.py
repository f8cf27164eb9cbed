"""The interface of a physics backend."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

import numpy as np

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array

Acts = list[Callable[[], object]]  # done one after the other


class Backend(ABC):
    """A plant: takes the command of each cable and moves the platform.

    The caller writes `command` and `external`, which are held until it writes them again, and reads `state`. The
    arrays are made here and never replaced, so that both sides may keep a reference.

    Attributes:
        command: (m,) tension of each cable, N.
        external: (6,) further wrench on the platform at its origin, world axes: force, N, then moment, N m.
        state: (13,) the platform, laid out as `cdpr.model` says; live: current after `reset` and after `step`.
        highest: (m,) what no tension has exceeded in size since `reset`, N: with ideal cables the command itself.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        self.robot = robot
        self.gravity = np.array(gravity, dtype=np.float64)
        self.physics_step = physics_step
        self.options = options
        self.command = np.zeros(robot.m)
        self.external = np.zeros(6)
        self.state = np.zeros(13)
        self.highest = self.command

    @abstractmethod
    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,) and the clock to zero."""

    @abstractmethod
    def step(self, n: int) -> None:
        """Advance by n physics steps. It checks nothing: the caller checks `state` after each call."""

    def acts(self, n: int) -> Acts | None:
        """Return what `step` does with this n, one thing after the other; None where it is not made of such.

        The loop calls operations with their arguments without Python: what `cdpr.native.bind.bind` returns, or a
        `cdpr.native.foreign.Foreign`. Where one returns something else than 0, the loop calls `refuse` with that.
        """
        return None

    def refuse(self, code: int) -> NoReturn:
        """Raise what says why one of `acts` returned something else than 0."""
        raise PluginError(f"{type(self).__name__} gave up a step with code {code}")

    def read_tension(self, tension: Array) -> None:
        """Write the tension of each cable (m,) at `state` under `command`, N: with ideal cables the command itself.

        A backend that knows other cables declares them in the property `cable_models`, see `cdpr.cables`, and tells
        tensions, `highest` and `cable_work`.
        """
        tension[:] = self.command

    def cable_work(self) -> float:
        """Return the work of the cables on the platform since `reset`, J; not asked of ideal cables."""
        raise PluginError(f"{type(self).__name__} knows ideal cables only")

    def readings(self, tension: Array, work: Array) -> tuple[Acts, Acts] | None:
        """Return what `read_tension(tension)` does, and what `work[0] = cable_work()`, likewise as `acts` does."""
        return None

    def engine_time(self) -> float | None:
        """Return the time since `reset` by the engine's own clock, s, or None where it has none.

        It serves to notice an engine that reset itself.
        """
        return None

    def clock_act(self, clock: Array) -> Callable[[], object]:
        """Return what writes `engine_time` into `clock` (1,), asked where it is not None: as `acts` does."""

        def read() -> None:
            clock[0] = self.engine_time()

        return read

    def log(self, columns: Mapping[str, Array]) -> None:
        """Take the arrays (width,) of the columns that its `PluginInfo` declares, by name, to write into.

        Called as soon as it is made, with arrays that nobody reads, and again by a simulation with those that it
        records: what stands in them when `reset` and `step` return, and NaN until something is written.
        """
        raise PluginError(f"{type(self).__name__} declares columns and has no method `log` to take them")

    def snapshot(self) -> object:
        """Return all that the plant's future depends on, for `restore`.

        A backend that can do this declares the property `snapshot: True`.
        """
        raise PluginError(f"{type(self).__name__} cannot take snapshots")

    def restore(self, snapshot: object) -> None:
        """Go back to a snapshot of this backend: what follows is the same to the bit."""
        raise PluginError(f"{type(self).__name__} cannot restore snapshots")

    def describe(self) -> dict[str, Any]:
        """Return what the record of a run should say of it beyond its options: plain data, as JSON holds it."""
        return {}

    def close(self) -> None:  # noqa: B027 - an optional hook
        """Free what the engine holds; the backend is not used afterwards."""
