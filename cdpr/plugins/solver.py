"""The interface of a tension solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.tension.status import BAD_INPUT

Kernel = Callable[[Array, Array, Array, Array, Array, Array, Array], int]


class TensionSolver(ABC):
    """Distributes a wrench among the cables: find t with W t = wrench and t_min <= t <= t_max.

    A solver never falls back by itself: what to do about an infeasible wrench is decided by the tension stage, which
    also checks every answer. A cable with t_min = t_max is locked, or cut, where that is 0: its tension is given.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        self.robot = robot
        self.options = options

    @abstractmethod
    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` and return a `cdpr.tension.Status`.

        W is (n, m), wrench (n,), the others (m,); all C-contiguous float64, the inputs not to be changed. n are the
        robot's degrees of freedom. On entry `tension` holds the tensions of the step before, NaN where there was none:
        a warm start, or what to stay close to. What it holds when the status is not OK is ignored.
        """

    def compiled(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Callable[[], int] | None:
        """Return what `solve` does with these arrays, as a kernel with its arguments.

        The loop then calls it without Python. That is a `functools.partial` of what `cdpr.model.jit.kernel` made, with
        numbers, C-contiguous arrays of 8-byte numbers, which stay where they are, and named tuples of these. None where
        it is no such thing.
        """
        return None

    def log(self, columns: Mapping[str, Array]) -> None:
        """Take the arrays (width,) of the columns that its `PluginInfo` declares, by name, to write into.

        Called as soon as it is made, with arrays that nobody reads, and again by a simulation with those that it
        records: what stands in them after `solve`, and NaN until something is written.
        """
        raise PluginError(f"{type(self).__name__} declares columns and has no method `log` to take them")

    def change(self, options: Any) -> None:
        """Take other options between two steps; only those differ that its `PluginInfo` declares as `changeable`.

        Nothing else changes: what is remembered of earlier calls stays. Raises CdprError, having changed nothing, where
        they do not fit the robot.
        """
        raise PluginError(f"{type(self).__name__} declares changeable options and has no method `change` to take them")

    def reset(self) -> None:  # noqa: B027 - an optional hook
        """Forget what was kept from earlier calls."""

    def snapshot(self) -> object:
        """Return all that its future answers depend on, beside the arguments of `solve`, for `restore`.

        That is nothing, unless it declares the property `warm_start`.
        """
        return None

    def restore(self, snapshot: object) -> None:  # noqa: B027 - an optional hook
        """Go back to a snapshot of this solver: what follows is the same to the bit."""


class CompiledSolver(TensionSolver):
    """A solver that is one compiled function without memory: called without detours, and in batches on all cores.

    Args:
        robot: as for any solver.
        options: likewise.
        kernel: `kernel(W, wrench, t_min, t_max, tension, parameters, work)`, compiled by `cdpr.model.jit.kernel`;
            returns the status as an integer.
        parameters: the options as numbers, handed to the kernel, which must not change them.
        rows: how many rows of work space the kernel needs.
        width: their length; by default max(n, m), enough for vectors over cables or freedoms.
        lanes: the same for eight problems at once, where there is such a kernel: its arguments are those of `kernel`,
            in which all arrays but `parameters` have one axis more, the last, of length eight; W is (n, m, 8). None
            has a step before. It returns a whole number whose bits say which of them, the first in the lowest bit, it
            has answered: with the very tensions, to the bit, for which `kernel` says OK. `kernel` is asked for all
            others; so it may leave whatever would hold up the rest. Where many rows are distributed it is called first.
        follows: whether an answer depends on the tensions of the step before. Where it does not, `lanes` is called in
            the steps of rollouts, too.
    """

    def __init__(
        self,
        robot: Robot,
        options: Any,
        kernel: Kernel,
        *,
        parameters: Sequence[float] = (),
        rows: int = 0,
        width: int | None = None,
        lanes: Kernel | None = None,
        follows: bool = True,
    ) -> None:
        super().__init__(robot, options)
        self.kernel = kernel
        self.lanes = lanes
        self.follows = follows
        self.parameters = np.array(parameters, dtype=float)
        self.work = np.zeros((rows, max(robot.n, robot.m) if width is None else width))

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        if len(tension) != len(t_min):  # the kernels hold the other arrays against each other and the work space
            return BAD_INPUT
        return self.kernel(W, wrench, t_min, t_max, tension, self.parameters, self.work)

    def compiled(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Callable[[], int] | None:
        """Return the kernel with these arrays, parameters and work space."""
        return partial(self.kernel, W, wrench, t_min, t_max, tension, self.parameters, self.work)
