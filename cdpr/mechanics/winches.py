"""The winches of one plant, as a backend keeps them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.plant import fixed, live, settle, step
from cdpr.model import Robot
from cdpr.model.kernels import copy
from cdpr.model.robot import Array


class Winches:
    """Turns the commands of a backend into tensions; its arrays are those of the backend.

    Attributes:
        fixed, live: what the kernels take, see `cdpr.mechanics.plant`.
        step: called before each step of a semi-implicit engine: writes `applied` and advances the winches.
        settle: evaluates tensions and work at `body` without advancing anything.
    """

    def __init__(
        self,
        robot: Robot,
        frame: BodyFrame,
        gravity: Array,
        command: Array,
        external: Array,
        body: Array,
        applied: Array,
        physics_step: float,
    ) -> None:
        self.fixed = fixed(robot, frame, gravity)
        self.live = live(robot.m, command, external, body, applied)
        self.step = partial(step, self.fixed, self.live, physics_step)
        self.settle = partial(settle, self.fixed, self.live)

    def reset(self) -> None:
        """Forget everything: the next evaluation starts anew."""
        for array in self.arrays:
            array[:] = 0.0
        self.live.winch[:] = np.nan

    def readings(self, tension: Array, work: Array) -> tuple[list[Callable[[], object]], list[Callable[[], object]]]:
        """Return what writes the tensions (m,) at `body`, one after the other, and what the work (1,), J."""
        return [self.settle, partial(copy, self.live.tension, tension)], [
            self.settle,
            partial(copy, self.live.work, work),
        ]

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All that the future depends on, besides the arrays of the backend."""
        live = self.live
        return live.winch, live.tension, live.highest, live.length, live.work, live.beside, live.place
