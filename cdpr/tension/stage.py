"""Tension stage of the loop: calls the solver, checks its answer, and applies the fallback policy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cdpr.base.errors import Diverged, Infeasible, PluginError, SolverFailed
from cdpr.base.problems import short_repr
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.tension.checks import LIMIT_TOLERANCE, allowed_residual, newton
from cdpr.tension.compiled import accept_tension
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation, perform
from cdpr.tension.policy import TOLD, WRITTEN, Policy, action
from cdpr.tension.status import Status

Solve = Callable[[Array, Array, Array, Array, Array], int]

MEANING = {
    Status.INFEASIBLE: "the solver reports that no tensions within the limits balance the wrench",
    Status.NOT_FOUND: "no answer of the solver passed the checks (finite, within the limits, balancing the wrench)",
    Status.UNSUPPORTED: "the solver does not support this robot or pose",
    Status.BAD_INPUT: "the solver refused its input",
}


@dataclass(frozen=True)
class StageSolver:
    """Solver and its fallback policy."""

    solve: Solve  # bound method of the solver
    name: str  # name of the solver, for messages
    respects_bounds: bool = True  # declared by the solver
    # Closest wrench within the limits (or, from a solver that ignores them, its answer clipped), the previous tensions,
    # or stop.
    policy: Policy = "best_effort"
    # Returns the compiled equivalent of `solve` on such arrays, or None.
    compiled: Callable[..., Callable[[], int] | None] | None = None


def refusal(
    names: Sequence[str], W: Array, wrench: Array, weights: Array, limits: Array, bounds: Array | None, answer: Array
) -> str:
    """Return which check of `accept_tension` an answer (m,) of the cables `names` fails, and by how much.

    Arguments as there; `bounds` are the limits again, None for a solver that ignores them.
    """
    reasons = [f"{name} {value}" for name, value in zip(names, answer.tolist(), strict=True) if not np.isfinite(value)]
    if reasons:
        return f"not finite: {', '.join(reasons)}"
    residual = accept_tension(W, wrench, weights, limits[0], limits[1], answer)[1][1]
    allowed = allowed_residual(wrench, weights, limits)
    if not residual <= allowed:
        reasons.append(f"the tensions miss the wrench by {residual:.3g} N; allowed: {allowed:.2g} N")
    if bounds is not None:
        beyond = np.maximum(bounds[0] - answer, answer - bounds[1])
        i, tolerance = int(np.argmax(beyond)), LIMIT_TOLERANCE * newton(bounds)
        if beyond[i] > tolerance:
            text = f"{names[i]} is {beyond[i]:.3g} N beyond its limits, {bounds[0, i]:g} to {bounds[1, i]:g} N"
            reasons.append(f"{text}; allowed: {tolerance:.2g} N")
    return "; ".join(reasons)


class TensionStage:
    """Stage that converts a wrench into tensions, once per control step.

    Args:
        robot: robot whose degrees of freedom are the directions in which the wrench is balanced, with the limits unless
            `cables` has them.
        solver: solver and fallback policy.
        live: current sample; tension and report are results. The solver receives the rows of W and of the required
            wrench for these directions.
        cables: limits and imposed tensions; by default the robot's limits, with all cables free.

    Attributes:
        live, cables: as given.
        operations: those of `distribute` in order; `imposing` likewise.
    """

    def __init__(
        self,
        robot: Robot,
        solver: StageSolver,
        live: Present,
        cables: Cables | None = None,
    ) -> None:
        self._name = solver.name
        self._stop = solver.policy == "stop"
        self._known = np.zeros(2, dtype=np.int64)
        self._refused = ""
        self.live = live
        self.cables = cables = cables or Cables.of(robot)
        W, wrench, limits = live.W, live.wrench, cables.limits
        rows = robot.rows
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows]
        selecting: list[Operation] = []
        if robot.n < 6:
            free_W, free_wrench = np.zeros((robot.n, robot.m)), np.zeros(robot.n)
            chosen = {"rows": np.array(rows), "matrix": free_W, "wrench": free_wrench}
            selecting = [Operation("distribution", bind("select_rows", full_matrix=W, full_wrench=wrench, **chosen))]
            W, wrench = free_W, free_wrench
        self._answer = answer = np.full(robot.m, np.nan)
        # read-only, so that the solver cannot change the data of the checks
        given = read_only(W), read_only(wrench), read_only(limits[0]), read_only(limits[1])
        bounds = limits if solver.respects_bounds else None
        self._refusal = partial(refusal, [cable.name for cable in robot.cables], W, wrench, weights, limits, bounds)
        shared = {"matrix": W, "wrench": wrench, "weights": weights, "limits": limits}
        shared |= {"tension": live.tension, "report": live.report}
        # without an answer, and with one: called with the solver's status
        self._replacing = [
            bind(
                "replace_tension",
                **shared,
                answer=answer,
                known=self._known,
                answered=int(answered),
                action=action(solver.policy, minds),
            )
            for answered, minds in ((False, True), (True, solver.respects_bounds))
        ]
        unanswered, refused = (None, None) if self._stop else self._replacing
        compiled = solver.compiled(*given, answer) if solver.compiled else None
        solve = compiled or partial(self._call_solver, partial(solver.solve, *given, answer))
        accept = bind("accept", **shared, answer=answer)
        self.operations = [
            *selecting,
            Operation("solver", solve, lambda status: self._replace(status, False), 1, unanswered),
            Operation("distribution", accept, lambda status: self._replace(status, True), 0, refused),
        ]
        self.imposing = [*selecting, Operation("distribution", bind("impose_tensions", **shared, held=cables.held))]

    @property
    def answered(self) -> bool:
        """True if the solver had written anything into its answer when it had to be replaced."""
        return bool(self._known[WRITTEN])

    @property
    def refusal(self) -> str:
        """Check that the first rejected answer failed, and by how much; "" if there is none."""
        return self._refused

    @refusal.setter
    def refusal(self, text: str) -> None:
        self._refused = text
        self._known[TOLD] = text != ""

    def distribute(self) -> None:
        """Write the tensions and the report for the current wrench.

        Raises:
            Infeasible, SolverFailed: under the policy `stop`.
            Diverged: if the wrench is not finite.
            PluginError: if the solver raised or returned no status.
        """
        perform(self.operations)

    def unanswered(self) -> str:
        """Return the message for a solver that wrote no tensions; it is called once more for its status."""
        solving = next(each for each in self.operations if each.name == "solver")
        status = self._status(solving.do())
        if status == Status.OK:
            return f"solver '{self._name}' wrote no tensions, or NaN: `solve` must write into the array it is given"
        return (
            f"solver '{self._name}' returned {status} for the initial state, without tensions: raise its limits of "
            "iterations and time, and its tolerance, if it has such options, or choose another solver"
        )

    def impose(self) -> None:
        """Set cables to their `held` tensions, and report the effect of all tensions on the wrench."""
        perform(self.imposing)

    def forget(self) -> None:
        """Clear all answers."""
        self._answer[:] = np.nan

    def reset(self) -> None:
        """Clear all answers and the reason of the last refusal."""
        self.forget()
        self.refusal = ""

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Previous answer."""
        return (self._answer,)

    def snapshot(self) -> object:
        """Return the memory besides limits and held cables: the previous answer."""
        return self._answer.copy(), self._known.copy(), self._refused

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        self._answer[:], self._known[:], self._refused = snapshot

    def _call_solver(self, solve: Callable[[], int]) -> int:
        """Call a Python solver; return its status."""
        try:
            status = solve()
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise PluginError(f"solver '{self._name}' raised {type(error).__name__}: {error}") from error
        if isinstance(status, np.ndarray):  # such as the tensions
            text = "`solve` writes into the array that it is given, and returns a status"
            raise PluginError(f"solver '{self._name}' returned an array, which is not a cdpr.tension.Status: {text}")
        return 0 if status == 0 else self._status(status).value

    def _status(self, code: Any) -> Status:
        try:
            return Status(code)
        except ValueError:
            raise PluginError(
                f"solver '{self._name}' returned {short_repr(code)}, which is not a cdpr.tension.Status"
            ) from None

    def _replace(self, code: int, answered: bool) -> None:
        """Apply the policy if the solver gave no answer, or none that passed the checks."""
        status = self._status(code)
        if answered and status == Status.NOT_FOUND and not self.refusal:
            self.refusal = self._refusal(self._answer)
        self._known[TOLD] = 1  # reported completely: answers beyond limits that the solver ignores have no message
        more = self._replacing[answered](float(code))
        self._known[TOLD] = self.refusal != ""
        if more:
            raise Diverged("the controller put out a wrench that is not finite")
        if self._stop:
            if status == Status.INFEASIBLE:
                raise Infeasible(f"{MEANING[status]} (solver '{self._name}', policy stop)")
            failed = f": {self.refusal}" if answered and self.refusal else ""
            text = f"solver '{self._name}' gave no valid answer: {MEANING[status]}{failed} (policy stop)"
            raise SolverFailed(text)
