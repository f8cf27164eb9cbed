"""Faulty solvers as plugins, with one fault each, and small robots for them."""

from __future__ import annotations

from time import sleep

import numpy as np
from scipy.optimize import linprog

from cdpr.model import Cable, Platform, Robot
from cdpr.plugins import PluginInfo
from cdpr.plugins.registry import Registry
from cdpr.tension import Status
from cdpr_solvers.closed_form import ClosedForm
from cdpr_solvers.pseudo_inverse import PseudoInverse
from cdpr_solvers.qp import MinimumNorm


def carriage(m: int = 2, *, mass: float = 10.0, limits: tuple[float, float] = (10.0, 100.0)) -> Robot:
    """A carriage between two cables on a rail along x, or hanging on the first alone."""
    anchors = [(5.0, 0.0, 0.0), (-5.0, 0.0, 0.0)][:m]
    cables = tuple(Cable(A, [0.0] * 3, *limits, name=f"c{i}") for i, A in enumerate(anchors))
    return Robot(Platform(mass, np.eye(3)), cables, ("x",), name="carriage")


def wall() -> Robot:
    """A point of 5 kg in a vertical plane between four cables: redundancy 2."""
    anchors = [(-1.5, 0, 2), (1.5, 0, 2), (-1.0, 0, 0), (1.2, 0, 0)]
    cables = tuple(Cable(A, [0] * 3, 5.0, 300.0, name=f"c{i}") for i, A in enumerate(anchors))
    return Robot(Platform(5.0, np.eye(3)), cables, ("x", "z"), name="wall")


class AlwaysOk(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        super().solve(W, wrench, t_min, t_max, tension)
        return Status.OK


class NeverFeasible(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        return Status.INFEASIBLE


class Unbalanced(MinimumNorm):
    """The first tension is 1e-3 of itself too large."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        tension[0] *= 1.001
        return status


class NotWritten(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        return Status.OK


class Suboptimal(MinimumNorm):
    """A hundredth of the way from the optimum to the roomiest distribution, which is a vertex away."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if status == Status.OK:
            tension[:] = 0.99 * tension + 0.01 * _program(W, wrench, t_min, t_max, slack=True)
        return status


class Roomiest(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if status == Status.OK:
            tension[:] = _program(W, wrench, t_min, t_max, slack=True)
        return status


class LeastSum(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if status == Status.OK:
            tension[:] = _program(W, wrench, t_min, t_max, slack=False)
        return status


def _program(W, wrench, t_min, t_max, *, slack):
    n, m = W.shape
    limits = np.block([[-np.eye(m), np.ones((m, 1))], [np.eye(m), np.ones((m, 1))]])
    cost = np.append(np.zeros(m), -1.0) if slack else np.append(np.ones(m), 0.0)
    s = (None, None) if slack else (0.0, 0.0)
    equal = np.hstack([W, np.zeros((n, 1))])
    return linprog(cost, limits, np.append(-t_min, t_max), equal, wrench, [(None, None)] * m + [s]).x[:m]


class Jumping(MinimumNorm):
    """Jumps by 3 N of internal tension if the wrench's first entry changes sign."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        if wrench[0] > 0.0:
            direction = np.linalg.svd(W)[2][-1]
            tension += 3.0 * direction / np.abs(direction).max() * np.sign(direction[0])
        return status


class Raising(MinimumNorm):
    calls = 0

    def solve(self, W, wrench, t_min, t_max, tension):
        self.calls += 1
        if self.calls > 15:
            raise ZeroDivisionError("division by zero")
        return super().solve(W, wrench, t_min, t_max, tension)


class Leaving(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        raise SystemExit("bye")


class NotMade(MinimumNorm):
    def __init__(self, robot, options):
        raise ValueError("no such robot")


class NoStatus(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        return 17


class Vandal(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        W[:] = 0.0
        return Status.OK


class Unsupporting(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        return Status.UNSUPPORTED


class Sleeping(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        sleep(2e-3)
        return super().solve(W, wrench, t_min, t_max, tension)


class Interrupted(MinimumNorm):
    def solve(self, W, wrench, t_min, t_max, tension):
        raise KeyboardInterrupt


SOUND = {"qp": MinimumNorm, "closed_form": ClosedForm, "pseudo_inverse": PseudoInverse}


def plugins(*rows: PluginInfo) -> Registry:
    """Registry of these solvers only, from a third-party package."""
    found = Registry()
    for row in rows:
        found.add("solver", row, "stranger", "1.0")
    return found


def plugin(solver: type, name: str = "fake", **properties: object) -> PluginInfo:
    """A row for a solver class."""
    return PluginInfo(name, f"{solver.__module__}:{solver.__name__}", "a fake", properties=properties)
