"""The tension stage of the loop: asks the solver, checks its answer and applies the policy where there is none."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from cdpr.errors import Diverged, Infeasible, PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.tension import box_least_squares as box
from cdpr.tension.checks import accept, judge, select
from cdpr.tension.status import Status

Policy = Literal["best_effort", "hold_tension", "stop"]
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
        robot: gives the limits.
        solve: the solver's bound method.
        name: the solver's name, for messages.
        respects_limits: what the solver declares.
        policy: what to do where the solver has no admissible answer: the nearest wrench within the limits (or, from a
            solver that respects none, its answer clipped), the previous tensions, or stop.
        W: (6, m) wrench matrix, live. The solver gets the rows of the robot's degrees of freedom.
        wrench: (6,) wanted wrench, live; likewise.
        tension: (m,) result.
        report: (4,) status, residual (N), margin (N), cables at a limit.
    """

    def __init__(
        self,
        robot: Robot,
        solve: Solve,
        name: str,
        respects_limits: bool,
        policy: Policy,
        W: Array,
        wrench: Array,
        tension: Array,
        report: Array,
    ) -> None:
        self._name = name
        self._policy = policy
        self._respects_limits = respects_limits
        self._tension = tension
        self._report = report
        limits = np.array([robot.tension_min, robot.tension_max])
        rows = robot.rows
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows]
        self._select = None
        if robot.n < 6:
            free_W, free_wrench = np.zeros((robot.n, robot.m)), np.zeros(robot.n)
            self._select = partial(select, np.array(rows), W, wrench, free_W, free_wrench)
            W, wrench = free_W, free_wrench
        self._answer = answer = np.full(robot.m, np.nan)
        self._limits = limits
        self._wrench = wrench
        # The solver cannot change what its answer is checked against.
        self._solve = partial(solve, read_only(W), read_only(wrench), robot.tension_min, robot.tension_max, answer)
        self._accept = partial(accept, W, wrench, weights, limits, answer, tension, report)
        self._judge = partial(judge, W, wrench, weights, limits, tension, report)
        work = np.zeros(box.work_size(robot.n, robot.m))
        self._best_effort = partial(box.box_least_squares, W, wrench, weights, limits[0], limits[1], tension, work)

    def distribute(self) -> None:
        """Write the tensions and the report for the present wrench.

        Raises Infeasible under the policy `stop`, Diverged where the wrench is not finite, PluginError where the
        solver raised or returned something that is no status.
        """
        if self._select is not None:
            self._select()
        try:
            status = self._solve()
        except (Exception, SystemExit) as error:
            raise PluginError(f"solver '{self._name}' raised {type(error).__name__}: {error}") from error
        answered = status == 0
        if answered:
            status = self._accept()
        if status != 0:
            self._fall_back(status, answered)

    def warm_up_policy(self) -> None:
        """Call what only an infeasible wrench needs, so that it does not compile in the loop."""
        self._best_effort()

    def forget(self) -> None:
        """Forget all answers."""
        self._answer[:] = np.nan

    @property
    def answered(self) -> bool:
        """Whether the solver has ever written anything into its answer."""
        return not np.isnan(self._answer).all()

    def _fall_back(self, code: int, answered: bool) -> None:
        """Find tensions where the solver gave none, or none that passed the checks."""
        try:
            status = Status(code)
        except ValueError:
            raise PluginError(f"solver '{self._name}' returned {code!r}, which is no cdpr.tension.Status") from None
        if not np.isfinite(self._wrench).all():
            raise Diverged("the controller put out a wrench that is not finite")
        tension, previous = self._tension, self._tension.copy()
        clip = answered and not self._respects_limits and np.isfinite(self._answer).all()
        if self._policy != "best_effort":
            tension[:] = previous
        elif clip:
            tension[:] = self._answer
        elif self._best_effort() < 0:
            tension[:] = previous
        np.clip(tension, self._limits[0], self._limits[1], out=tension)
        self._judge()
        self._report[0] = status
        if self._policy == "stop":
            raise Infeasible(f"{MEANING[status]} (solver '{self._name}', policy stop)")
