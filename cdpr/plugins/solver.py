"""Interface of tension solvers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.arrays import reals
from cdpr.native.bind import LANES, bind
from cdpr.native.foreign import Foreign
from cdpr.native.operations import Operation, operations
from cdpr.native.own import Own
from cdpr.tension.status import BAD_INPUT

if TYPE_CHECKING:
    from cdpr.native.library import Bound


# Of threads that solve with arrays that are copied. Python's own lock is held during the call anyway.
_turn = RLock()


class TensionSolver(ABC):
    """Tension distribution: find t with W t = wrench and t_min <= t <= t_max.

    A solver has no fallback of its own: the tension stage decides how to handle infeasible wrenches, and it checks
    every answer. A cable with t_min = t_max is locked at that tension; at 0 it is cut.

    Args:
        robot: geometry, limits and degrees of freedom; the nominal robot, if the scenario has one.
        options: instance of the plugin's options model; None if it has none.

    Example:
        >>> import numpy as np
        >>> import cdpr
        >>> class LeastNorm(cdpr.plugins.TensionSolver):
        ...     def solve(self, W, wrench, t_min, t_max, tension):
        ...         tension[:] = np.linalg.pinv(W) @ wrench
        ...         inside = ((t_min <= tension) & (tension <= t_max)).all()
        ...         return cdpr.tension.Status.OK if inside else cdpr.tension.Status.NOT_FOUND
        >>> robot = cdpr.load_robot("caroca")
        >>> cdpr.distribute(robot, robot.home, solver=LeastNorm(robot, None)).status
        <Status.OK: 0>
    """

    source: Own | None = None  # source of its compiled operation, if it is not in the kernel library

    def __init__(self, robot: Robot, options: Any) -> None:
        self.robot = robot
        self.options = options

    @abstractmethod
    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` and return a `cdpr.tension.Status`.

        All arrays are C-contiguous float64. The robot has n degrees of freedom.

        Args:
            W: (n, m), wrench matrix, 1 and m; read-only.
            wrench: (n,), required wrench of the cables, N and N m, world axes; read-only.
            t_min: (m,), lowest tensions, N; read-only.
            t_max: (m,), highest tensions, N; read-only.
            tension: (m,), N; written. On entry it has the tensions of the previous step, NaN if there was none, as a
                warm start or for continuity. Its content is ignored if the status is not OK.

        Returns:
            A `cdpr.tension.Status`.
        """

    def compiled(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Callable[[], int] | None:
        """Return the compiled equivalent of `solve` on these arrays; None if there is none.

        The loop then calls it without Python: a result of `cdpr.native.bind.bind` or a `cdpr.native.foreign.Foreign`.
        The arrays are not moved.

        Args:
            W: (n, m), as in `solve`.
            wrench: (n,).
            t_min: (m,), N.
            t_max: (m,), N.
            tension: (m,), N; written.

        Returns:
            The operation, or None.
        """
        return None

    def log(self, columns: Mapping[str, Array]) -> None:
        """Store the arrays (width,) of its declared columns, by name, to write into.

        It is called once after construction with unused arrays, and again by a simulation with its recorded arrays:
        their values after `solve`, NaN until something is written.

        Args:
            columns: array (width,) of each declared column, by name.

        Raises:
            PluginError: if the solver does not implement it.
        """
        raise PluginError(f"{type(self).__name__} declares columns but has no method `log` that receives them")

    def change(self, options: Any) -> None:
        """Change the options between two steps; only options declared as `changeable` differ.

        The memory of earlier calls is kept.

        Args:
            options: instance of the plugin's options model.

        Raises:
            CdprError: if they do not fit the robot; nothing is changed then.
        """
        raise PluginError(f"{type(self).__name__} declares changeable options but has no method `change`")

    def reset(self) -> None:  # noqa: B027 - an optional hook
        """Clear the memory of earlier calls."""

    def snapshot(self) -> object:
        """Return the complete internal state for `restore`, besides the arguments of `solve`.

        It is empty unless the solver declares the property `warm_start`.
        """
        return None

    def restore(self, snapshot: object) -> None:  # noqa: B027 - an optional hook
        """Restore a snapshot of this solver; the continuation is identical to the bit.

        Args:
            snapshot: result of `snapshot` of the same object.
        """


class CompiledSolver(TensionSolver):
    """Solver that is one compiled operation without memory: called without Python, and in batches on all cores.

    The operation is either one of the kernel library, whose fields begin as those of a `TensionProblem`
    (`cdpr/tension/tension_problem.hpp`), or your own function `int f(void *place, double time)` that
    returns the status. Its `place` is then the struct

        const double *matrix;       // (n, m), W, row by row
        const double *wrench;       // (n)
        const double *tension_min;  // (m)
        const double *tension_max;  // (m)
        double *tension;            // (m), as in `solve`
        int64_t n, m;

    followed by the `parameters` in their order and the arrays of `work`. It must not change the other inputs, and must
    not read a work array that the same call did not write. Several threads call it concurrently, each with its own
    `tension` and work arrays.

    Args:
        robot: as in any solver.
        options: as in any solver.
        operation: name of the operation; or the address of your function, or an object with the attribute `address`,
            such as a `numba.cfunc`.
        parameters: options: arrays and numbers by name. Operations of the library receive them as fields.
        work: shapes of the work arrays of your function.
        follows: True if an answer depends on the tensions of the previous step. Otherwise rollouts solve eight problems
            at once by the operation NAME_lanes, if the library has one.

    Example:
        >>> import cdpr
        >>> class MidRange(cdpr.plugins.CompiledSolver):
        ...     def __init__(self, robot, options):
        ...         super().__init__(robot, options, "closed_form", follows=False)
        >>> robot = cdpr.load_robot("caroca")
        >>> cdpr.distribute(robot, robot.home, solver=MidRange(robot, None)).status
        <Status.OK: 0>
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
                pass  # other shapes, types or layout
        return self._solve_copies(W, wrench, t_min, t_max, tension)

    def _solve_copies(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Solve with arrays of any layout."""
        given = reals(W=W, wrench=wrench, t_min=t_min, t_max=t_max, tension=tension).values()
        with _turn:
            call, arrays = self._single_call
            if any(array.shape != own.shape for array, own in zip(given, arrays, strict=True)):
                return BAD_INPUT
            for array, own in zip(given, arrays, strict=True):
                own[...] = array
            status, answer = call(), arrays[-1].copy()
        tension[...] = answer  # may itself call a solver
        return status

    def compiled(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Bound | Foreign:
        """Bind the operation to these arrays, its parameters, and its own work arrays."""
        if not isinstance(self.operation, str):
            work = [np.zeros(shape) for shape in self._shapes]
            sizes = self.robot.n, self.robot.m
            own = self.parameters.values()
            return Foreign(self.operation, W, wrench, t_min, t_max, tension, *sizes, *own, *work)
        given = _arguments(W, wrench, t_min, t_max, tension)
        return _bound(operations()[self.operation], given | self.parameters)

    def side_by_side(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> Bound | None:
        """Bind the operation for eight problems at once; None if there is none.

        The last axis of the arrays has length 8. The operation returns a bit mask of the problems without status OK,
        the first in the lowest bit; the tensions of the others equal those of `solve` to the bit. All answers are first
        steps unless `tension` has the previous tensions.

        Args:
            W: (n, m, 8).
            wrench: (n, 8).
            t_min: (m, 8), N.
            t_max: (m, 8), N.
            tension: (m, 8), N; written.

        Returns:
            The bound operation, or None.
        """
        operation = operations().get(f"{self.operation}_lanes")
        if operation is None:
            return None
        wide = {field.name for field in operation.fields if field.type == "lanes*"}
        own = {name: _repeated(value) if name in wide else value for name, value in self.parameters.items()}
        return _bound(operation, _arguments(W, wrench, t_min, t_max, tension) | own)

    @property
    def work(self) -> tuple[Array, ...]:
        """Arrays that `solve` writes besides the tensions; no answer depends on their previous content."""
        call, arrays = self._single_call
        kept = [*arrays, *self.parameters.values()]
        found: Any = call.arrays
        return tuple(each for each in found if not any(each is other for other in kept))

    @cached_property
    def _single_call(self) -> tuple[Bound | Foreign, tuple[Array, ...]]:
        """Operation of `solve`, and arrays for its arguments."""
        n, m = self.robot.n, self.robot.m
        arrays = np.empty((n, m)), np.empty(n), np.empty(m), np.empty(m), np.empty(m)
        return self.compiled(*arrays), arrays

    @cached_property
    def _on(self) -> tuple[Callable[..., int], bytes] | None:
        """Call on given arrays, and the positions of their addresses in its struct; None for foreign operations."""
        call, arrays = self._single_call
        if isinstance(call, Foreign):
            return None
        names = [field.name for field in operations()[call.name].fields]
        return call.on, bytes(names.index(name) for name in _arguments(*arrays))


def _arguments(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> dict[str, Any]:
    return {"matrix": W, "wrench": wrench, "tension_min": t_min, "tension_max": t_max, "tension": tension}


def _bound(operation: Operation, given: dict[str, Any]) -> Bound:
    """Bind an operation with its own arrays for outputs other than the tensions, such as the status."""
    for field in operation.fields:
        if field.role == "out" and field.name not in given:
            given[field.name] = np.empty([dimension.evaluate({}) for dimension in field.shape])
    return bind(operation.name, **given)


def _repeated(array: Array) -> Array:
    """Return an array with an additional last axis along which its values are repeated."""
    return np.repeat(array[..., None], LANES, axis=-1)
