"""Deliberately broken solvers, each with the checks that must catch it."""

from __future__ import annotations

import numpy as np

from cdpr.plugins import CABLES, Column, TensionSolver
from cdpr.tension import Status
from cdpr_solvers.pseudo_inverse import PseudoInverse
from cdpr_solvers.qp import MinimumNorm


def square(tension, t_min, t_max):
    """Objective of `qp`, as the cost of a plugin."""
    return float(tension @ tension)


QP = {"exact": True, "respects_bounds": True, "continuity": "C0", "coverage": "full", "objective": "min_norm"}


class Scribbling(MinimumNorm):
    """It scales the wrench in place."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        wrench *= 1.0 + 1e-12
        return status


class Aliasing(MinimumNorm):
    """It keeps the array of the last answer and writes there, too."""

    last = None

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if self.last is not None:
            self.last[:] = tension
        self.last = tension
        return status


class Random(MinimumNorm):
    """A random start shows in the last digits."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        tension *= 1.0 + 1e-13 * np.random.default_rng().random()
        return status


class StaleWarmStart(MinimumNorm):
    """It leans towards its last answer, and forgets it nowhere."""

    last = 0.0

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if status == Status.OK:
            tension += 1e-3 * (self.last - tension)
            self.last = tension.copy()
        return status


class Weighing(MinimumNorm):
    """It adds a share of the platform's mass to its answers."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        tension *= 1.0 + 1e-15 * self.robot.platform.mass
        return status


class Raising(MinimumNorm):
    """numpy's pinv raises on NaN."""

    def solve(self, W, wrench, t_min, t_max, tension):
        np.linalg.pinv(W)
        return super().solve(W, wrench, t_min, t_max, tension)


class Owner(MinimumNorm):
    """It wants arrays of its own, which it may write."""

    def solve(self, W, wrench, t_min, t_max, tension):
        if W.base is not None or not W.flags.writeable:
            return Status.BAD_INPUT
        return super().solve(W, wrench, t_min, t_max, tension)


class Leaning(TensionSolver):
    """It starts from what its last call left, which only matters where that is absurd."""

    def __init__(self, robot, options):
        super().__init__(robot, options)
        self.inner = MinimumNorm(robot, options)
        self.kept = np.zeros(robot.m)

    def solve(self, W, wrench, t_min, t_max, tension):
        status = self.inner.solve(W, wrench, t_min, t_max, tension)
        if not (np.abs(self.kept) < 1e20).all():
            status = Status.NOT_FOUND
        self.kept[:] = np.nan_to_num(tension)
        return status


class StaleWork(MinimumNorm):
    """It reads a corner of its work space before it has written there."""

    def solve(self, W, wrench, t_min, t_max, tension):
        stale = self.work[-1].flat[-1]
        return super().solve(W, wrench, t_min, t_max, tension) if stale < 1e20 else Status.NOT_FOUND


class Rounding(MinimumNorm):
    """Eight at once it answers nearly to the last bit."""

    def __init__(self, robot, options):
        super().__init__(robot, options)
        eight = self.lanes

        def rounded(W, wrench, t_min, t_max, tension, parameters, work):
            found = eight(W, wrench, t_min, t_max, tension, parameters, work)
            tension *= 1.0 + 2.0**-52
            return found

        self.lanes = rounded if eight else None


class HalfHearted(MinimumNorm):
    """A thousandth of the way from the optimum of its cost to the middle, in the null space."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        _move(W, t_min, t_max, tension, 1e-3, status)
        return status


class Credulous(MinimumNorm):
    """It takes whatever comes near: what misses by less than a hundredth counts as balanced."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if status == Status.INFEASIBLE and np.isfinite(wrench).all():
            best = np.clip(np.linalg.pinv(W, rcond=1e-9) @ wrench, t_min, t_max)
            if np.abs(W @ best - wrench).max() < 1e-2 * np.abs(wrench).max():
                tension[:] = best
                return Status.OK
        return status


class Timid(MinimumNorm):
    """It takes a thin set of admissible tensions for none."""

    def solve(self, W, wrench, t_min, t_max, tension):
        if 0.0 < (t_max - t_min).max() < 1e-6 * np.abs(t_max).max():
            return Status.INFEASIBLE
        return super().solve(W, wrench, t_min, t_max, tension)


class NoStatus(MinimumNorm):
    """It returns whether it succeeded."""

    def solve(self, W, wrench, t_min, t_max, tension):
        return super().solve(W, wrench, t_min, t_max, tension) == Status.OK


class FullRankOnly(TensionSolver):
    """The normal equations without a thought of rank, cut off at the limits."""

    def solve(self, W, wrench, t_min, t_max, tension):
        try:
            tension[:] = W.T @ np.linalg.solve(W @ W.T + 1e-9 * np.eye(len(W)), wrench)
        except np.linalg.LinAlgError:
            return Status.NOT_FOUND
        return Status.OK


class Leaking(MinimumNorm):
    def __init__(self, robot, options):
        super().__init__(robot, options)
        self.history = []

    def solve(self, W, wrench, t_min, t_max, tension):
        self.history.append(np.ones(200))
        return super().solve(W, wrench, t_min, t_max, tension)


class Inexact(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        tension *= 1.0 + 1e-5
        return status


class Unanswering(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        return Status.NOT_FOUND


class Unwritten(MinimumNorm):
    """Its answer goes to an array of its own."""

    def solve(self, W, wrench, t_min, t_max, tension):
        return super().solve(W, wrench, t_min, t_max, tension.copy())


class Unbounded(PseudoInverse):
    """It claims to respect limits at which it does not look."""


class GivesUp(MinimumNorm):
    """It does not get on when a cable is at a limit."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        return Status.NOT_FOUND if (tension <= t_min + 1e-9).any() else status


class Unwilling(MinimumNorm):
    """It declares two redundant cables, and does not support one."""

    def solve(self, W, wrench, t_min, t_max, tension):
        if W.shape[1] == W.shape[0] + 1:
            return Status.UNSUPPORTED
        return super().solve(W, wrench, t_min, t_max, tension)


class Clipping(PseudoInverse):
    """It clips to the limits and calls that an answer."""

    def solve(self, W, wrench, t_min, t_max, tension):
        super().solve(W, wrench, t_min, t_max, tension)
        np.clip(tension, t_min, t_max, out=tension)
        return Status.OK


class OwnLimits(MinimumNorm):
    """It takes the robot's limits instead of its arguments."""

    def solve(self, W, wrench, t_min, t_max, tension):
        return super().solve(W, wrench, self.robot.tension_min, self.robot.tension_max, tension)


class Favouring(MinimumNorm):
    """It puts off the first cable as far as the null space allows."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        _move(W, t_min, t_max, tension, 0.5, status)
        return status


class Jumping(MinimumNorm):
    """It changes sides where the wrench passes a mark."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if np.isfinite(wrench).all():
            _move(W, t_min, t_max, tension, 0.5 * (int(np.floor(np.abs(wrench).sum() / 100)) % 2), status)
        return status


def _move(W, t_min, t_max, tension, share, status):
    """Move along the null space in favour of the first cable, staying within the limits."""
    if status != Status.OK or not np.isfinite(W).all():
        return
    direction = np.linalg.svd(W)[2][np.linalg.matrix_rank(W) :].T
    direction = direction @ direction[0] if direction.size else np.zeros(len(tension))
    room = np.where(direction > 1e-9, (t_max - tension) / np.maximum(direction, 1e-9), np.inf)
    room = np.minimum(room, np.where(direction < -1e-9, (tension - t_min) / np.maximum(-direction, 1e-9), np.inf))
    if np.isfinite(room.min()):
        tension += share * max(room.min(), 0.0) * direction


class Unlogged(MinimumNorm):
    """It writes the first number of its column only."""

    columns = (Column("share", CABLES, "", "Tension by its limit"),)

    def log(self, columns):
        self.share = columns["share"]

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        self.share[0] = tension[0] / t_max[0]
        return status


class Deaf(MinimumNorm):
    """It keeps what it was made with."""

    changeable = ("about",)

    def change(self, options):
        self.options = options


# Broken solver -> what it declares besides what qp does, and the checks that must fail. It may fail others too.
MUTANTS = {
    Scribbling: ({}, ["inputs_stay_unchanged"]),
    Aliasing: ({}, ["answers_are_not_shared"]),
    Random: ({}, ["instances_agree"]),
    StaleWarmStart: ({"warm_start": True}, ["answers_do_not_depend_on_the_past", "reset_forgets"]),
    Weighing: ({"platform_independent": True}, ["the_platform_does_not_matter"]),
    Raising: ({}, ["bad_input_raises_nothing"]),
    Owner: ({}, ["views_are_answered_alike"]),
    StaleWork: ({}, ["memory_never_decides"]),
    Leaning: ({}, ["memory_never_decides"]),
    Rounding: ({}, ["eight_are_answered_as_one"]),
    HalfHearted: ({"objective": "own", "cost": "solver_mutants:square"}, ["objective_is_reached"]),
    Credulous: ({}, ["misleading_problems_are_answered_truly"]),
    Timid: ({}, ["misleading_problems_are_answered_truly"]),
    NoStatus: ({}, ["answers_balance"]),
    FullRankOnly: ({"respects_bounds": False}, ["unreachable_is_never_ok", "degenerate_problems_are_answered"]),
    Leaking: ({}, ["nothing_leaks"]),
    Inexact: ({}, ["answers_balance"]),
    Unanswering: ({}, ["answers_balance", "what_can_be_solved_is_solved"]),
    Unwritten: ({}, ["answers_balance"]),
    Unbounded: ({}, ["answers_are_within_the_limits", "infeasible_is_never_ok"]),
    GivesUp: ({}, ["what_can_be_solved_is_solved"]),
    Unwilling: ({"max_redundancy": 2}, ["what_can_be_solved_is_solved"]),
    Clipping: ({}, ["infeasible_is_never_ok", "answers_balance"]),
    OwnLimits: ({}, ["limits_are_the_arguments"]),
    Favouring: ({}, ["cables_may_come_in_any_order", "objective_is_reached"]),
    Jumping: ({}, ["answers_are_continuous"]),
    Unlogged: ({}, ["columns_are_written"]),
    Deaf: ({}, ["options_change"]),
}
