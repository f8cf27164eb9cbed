"""The interface of a tension solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import LANES, bind
from cdpr.native.foreign import Foreign
from cdpr.native.operations import Operation, operations
from cdpr.native.own import Own
from cdpr.tension.status import BAD_INPUT

if TYPE_CHECKING:
    from cdpr.native.library import Bound


class TensionSolver(ABC):
    """Distributes a wrench among the cables: find t with W t = wrench and t_min <= t <= t_max.

    A solver never falls back by itself: what to do about an infeasible wrench is decided by the tension stage, which
    also checks every answer. A cable with t_min = t_max is locked, or cut, where that is 0: its tension is given.
    """

    source: Own | None = None  # of its compiled operation, if that is not in the kernel library

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
        """Return what `solve` does with these arrays, as a compiled operation.

        The loop then calls it without Python: what `cdpr.native.bind.bind` returns, or a `cdpr.native.foreign.Foreign`.
        The arrays stay where they are. None if there is no such operation.
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
    """A solver that is one compiled operation without memory: called without Python, and in batches on all cores.

    Either an operation of the kernel library, whose fields begin as those of a `TensionProblem`
    (`cdpr/native/include/cdpr/tension_problem.hpp`); or a function of your own, `int f(void *place, double time)`,
    that returns the status. Its `place` is then the struct

        const double *matrix;       // (n, m), W, row by row
        const double *wrench;       // (n)
        const double *tension_min;  // (m)
        const double *tension_max;  // (m)
        double *tension;            // (m), as of `solve`
        int64_t n, m;

    and after it the `parameters` in their order, then the arrays of `work`. It must not change the other inputs, and
    must read no work array that the same call did not write. Several threads call it at once, each with a `tension` and
    work arrays of its own.

    Args:
        robot: As for any solver.
        options: Likewise.
        operation: Name of the operation; or the address of your function, or an object that has it as `address`, such
            as a `numba.cfunc`.
        parameters: The options: arrays and numbers by name. Operations of the library take them as their fields.
        work: Shapes of work arrays that your function needs.
        follows: Whether an answer depends on the tensions of the step before. If not, rollouts solve eight problems at
            once by the operation NAME_lanes, if the library has one.
    """

    def __init__(
        self,
        robot: Robot,
        options: Any,
        operation: Any,
        *,
        parameters: Mapping[str, Any] | None = None,
        work: Sequence[tuple[int, ...]] = (),
        follows: bool = True,
    ) -> None:
        super().__init__(robot, options)
        self.operation = operation
        self.parameters = dict(parameters or {})
        self.follows = follows
        self._shapes = work

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        if self._on is not None:
            call, positions = self._on
            try:
                return call(positions, W, wrench, t_min, t_max, tension)
            except (BufferError, TypeError, ValueError):
                pass  # they have other shapes, or are not as they should be
        return self._solve_copies(W, wrench, t_min, t_max, tension)

    def _solve_copies(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Solve, the arrays having any layout."""
        call, arrays = self._alone
        given = W, wrench, t_min, t_max, tension
        if any(array.shape != own.shape for array, own in zip(given, arrays, strict=True)):
            return BAD_INPUT
        if self._on is None:
            for array, own in zip(given, arrays, strict=True):
                own[...] = array
            status = call()
        else:  # another thread may ask at the same time
            arrays = tuple(np.array(array, dtype=np.float64, order="C") for array in given)
            status = self._on[0](self._on[1], *arrays)
        tension[...] = arrays[-1]
        return status

    def compiled(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Bound | Foreign:
        """Bind the operation to these arrays, its parameters, and work arrays of its own."""
        if not isinstance(self.operation, str):
            work = [np.empty(shape) for shape in self._shapes]
            sizes = self.robot.n, self.robot.m
            own = self.parameters.values()
            return Foreign(self.operation, W, wrench, t_min, t_max, tension, *sizes, *own, *work)
        given = _arguments(W, wrench, t_min, t_max, tension)
        return _bound(operations()[self.operation], given | self.parameters)

    def side_by_side(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Bound | None:
        """Bind the operation for eight problems at once; None if there is none.

        The last axis of the arrays has length 8. It returns the bits of the problems that are not answered with OK, the
        first in the lowest bit; the tensions of the others are those of `solve`, to the bit. None is answered after a
        step before, unless `tension` holds its tensions.
        """
        operation = operations().get(f"{self.operation}_lanes")
        if operation is None:
            return None
        wide = {field.name for field in operation.fields if field.type == "lanes*"}
        own = {name: _repeated(value) if name in wide else value for name, value in self.parameters.items()}
        return _bound(operation, _arguments(W, wrench, t_min, t_max, tension) | own)

    @property
    def work(self) -> tuple[Array, ...]:
        """Arrays that `solve` writes beside the tensions; no answer depends on what they hold before."""
        call, arrays = self._alone
        kept = [*arrays, *self.parameters.values()]
        found: Any = call.arrays
        return tuple(each for each in found if not any(each is other for other in kept))

    @cached_property
    def _alone(self) -> tuple[Bound | Foreign, tuple[Array, ...]]:
        """The operation of `solve`, and arrays for its arguments."""
        n, m = self.robot.n, self.robot.m
        arrays = np.empty((n, m)), np.empty(n), np.empty(m), np.empty(m), np.empty(m)
        return self.compiled(*arrays), arrays

    @cached_property
    def _on(self) -> tuple[Callable[..., int], bytes] | None:
        """A call on given arrays, and the positions of their addresses in its struct."""
        call, arrays = self._alone
        if isinstance(call, Foreign):
            return None
        names = [field.name for field in operations()[call.name].fields]
        return call.on, bytes(names.index(name) for name in _arguments(*arrays))


def _arguments(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> dict[str, Any]:
    return {"matrix": W, "wrench": wrench, "tension_min": t_min, "tension_max": t_max, "tension": tension}


def _bound(operation: Operation, given: dict[str, Any]) -> Bound:
    """Bind an operation; what it writes beside the tensions, such as the status, goes into arrays of its own."""
    for field in operation.fields:
        if field.role == "out" and field.name not in given:
            given[field.name] = np.empty([dimension.evaluate({}) for dimension in field.shape])
    return bind(operation.name, **given)


def _repeated(array: Array) -> Array:
    """Return an array with one axis more, the last, along which its numbers are the same."""
    return np.repeat(array[..., None], LANES, axis=-1)
