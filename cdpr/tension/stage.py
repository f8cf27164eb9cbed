"""The tension stage of the loop: asks the solver, checks its answer and applies the policy where there is none."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cdpr.errors import Diverged, Infeasible, PluginError, Unanswered
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.tension import box_least_squares as box
from cdpr.tension.checks import accept, impose, select
from cdpr.tension.policy import Policy, action, fall_back
from cdpr.tension.status import Status

Solve = Callable[[Array, Array, Array, Array, Array], int]

MEANING = {
    Status.INFEASIBLE: "the solver says that no tensions within the limits balance the wrench",
    Status.NOT_FOUND: "no answer of the solver passed the checks (finite, within the limits, balancing the wrench)",
    Status.UNSUPPORTED: "the solver says that it does not support this robot or pose",
    Status.BAD_INPUT: "the solver refused its input",
}


class TensionStage:
    """Turns a wrench into tensions, once per control step.

    Args:
        robot: gives the limits, and as its degrees of freedom the directions in which the wrench is to be balanced.
        solve: the solver's bound method.
        name: the solver's name, for messages.
        respects_bounds: what the solver declares.
        policy: what to do where the solver has no admissible answer: the nearest wrench within the limits (or, from a
            solver that respects none, its answer clipped), the previous tensions, or stop.
        W: (6, m) wrench matrix, live. The solver gets the rows of these directions.
        wrench: (6,) wanted wrench, live; likewise.
        tension: (m,) result.
        report: (4,) status, residual (N), margin (N), cables at a limit.
        limits: (2, m) lower and upper limits, N, live; the robot's unless given.
        held: (m,) tensions, N, that `impose` gives the cables whatever was distributed; NaN for those that are free,
            all unless given.

    Attributes:
        limits, held: as given.
        answered: whether the solver has written anything into its answer where it had to be replaced.
    """

    def __init__(
        self,
        robot: Robot,
        solve: Solve,
        name: str,
        respects_bounds: bool,
        policy: Policy,
        W: Array,
        wrench: Array,
        tension: Array,
        report: Array,
        limits: Array | None = None,
        held: Array | None = None,
    ) -> None:
        self._name = name
        self._stop = policy == "stop"
        self._tension = tension
        self.answered = False
        if limits is None:
            limits = np.array([robot.tension_min, robot.tension_max])
        self.limits = limits
        rows = robot.rows
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows]
        self._select = None
        if robot.n < 6:
            free_W, free_wrench = np.zeros((robot.n, robot.m)), np.zeros(robot.n)
            self._select = partial(select, np.array(rows), W, wrench, free_W, free_wrench)
            W, wrench = free_W, free_wrench
        self._answer = answer = np.full(robot.m, np.nan)
        self.held = np.full(robot.m, np.nan) if held is None else held
        # The solver cannot change what its answer is checked against.
        given = read_only(W), read_only(wrench), read_only(limits[0]), read_only(limits[1])
        self._solve = partial(solve, *given, answer)
        self._accept = partial(accept, W, wrench, weights, limits, answer, tension, report)
        self._impose = partial(impose, self.held, W, wrench, weights, limits, tension, report)
        spare = np.zeros((box.work_rows(robot.n, robot.m), max(robot.n, robot.m)))
        self._actions = action(policy, True), action(policy, respects_bounds)  # without an answer, and with one
        self._arguments = (W, wrench, weights, limits, answer, tension, report, spare)

    def distribute(self) -> None:
        """Write the tensions and the report for the present wrench.

        Raises Infeasible or Unanswered under the policy `stop`, Diverged where the wrench is not finite, PluginError
        where the solver raised or returned something that is no status.
        """
        if self._select is not None:
            self._select()
        try:
            status = self._solve()
        except (Exception, SystemExit) as error:
            raise PluginError(f"solver '{self._name}' raised {type(error).__name__}: {error}") from error
        if isinstance(status, np.ndarray):  # such as the tensions
            text = "`solve` writes into the array that it is given, and returns a status"
            raise PluginError(f"solver '{self._name}' returned an array, which is no cdpr.tension.Status: {text}")
        answered = status == 0
        if answered:
            status = self._accept()
        if status != 0:
            self._replace(status, answered)

    def impose(self) -> None:
        """Give the cables the tensions that they are `held` at, and report what all tensions do for the wrench."""
        if self._select is not None:
            self._select()
        self._impose()

    def warm_up_policy(self) -> None:
        """Call what only an infeasible wrench needs, so that it does not compile in the loop."""
        fall_back(self._actions[0], Status.NOT_FOUND.value, *self._arguments)

    def forget(self) -> None:
        """Forget all answers."""
        self._answer[:] = np.nan

    def follow(self) -> None:
        """Take the present tensions, which somebody else chose, for its answer of the step before."""
        self._answer[:] = self._tension

    def snapshot(self) -> object:
        """Return what future answers depend on beside limits and held cables: the answer before."""
        return self._answer.copy(), self.answered

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        self._answer[:], self.answered = snapshot

    def _replace(self, code: int, answered: bool) -> None:
        """Apply the policy where the solver gave no answer, or none that passed the checks."""
        try:
            status = Status(code)
        except ValueError:
            raise PluginError(f"solver '{self._name}' returned {code!r}, which is no cdpr.tension.Status") from None
        if not self.answered:
            self.answered = not np.isnan(self._answer).all()
        if not fall_back(self._actions[answered], status.value, *self._arguments):
            raise Diverged("the controller put out a wrench that is not finite")
        if self._stop:
            if status == Status.INFEASIBLE:
                raise Infeasible(f"{MEANING[status]} (solver '{self._name}', policy stop)")
            raise Unanswered(f"solver '{self._name}' gave no valid answer: {MEANING[status]} (policy stop)")
        self._answer[:] = self._tension  # what the solver finds as the tensions of the step before
