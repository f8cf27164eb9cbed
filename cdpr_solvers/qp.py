"""Minimum 2-norm within the limits: min sum w_i (t_i - ref_i)^2 with W t = wrench, t_min <= t <= t_max."""

from __future__ import annotations

import math
from typing import Any

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import nearest
from cdpr.tension.null_space import reduce
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK, UNSUPPORTED
from cdpr.tension.verdict import verdict
from cdpr_solvers.options import QpOptions, per_cable

ZERO, MIDDLE, PREVIOUS, GIVEN = range(4)
ABOUT = {"zero": ZERO, "middle": MIDDLE, "previous": PREVIOUS, "given": GIVEN}
REFERENCE = 3  # parameters: about, largest change (inf: any), whether weighted, m references, m roots of weights


class MinimumNorm(CompiledSolver):
    """Exact for any number of cables and any rank, continuous; a convex quadratic program (Bruckmann et al. 2006).

    With t = c + N x, c the solution of least norm and N an orthonormal basis of the null space, |t|^2 = |c|^2 + |x|^2:
    the optimum is the point of least norm in a polytope in m - n dimensions. A reference moves the origin to N^T ref;
    weights scale the cables: with D = diag(sqrt(w)), D t solves the problem of W D^-1.

    `change` narrows the limits to t_previous +- change. Where no distribution lies within that window the answer is
    NOT_FOUND. In a first step nothing is previous: then `about: previous` is about zero and any change is allowed.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        if not isinstance(options, QpOptions):  # a solver built upon this one, with options of its own or none
            options = QpOptions()
        about = options.about
        if (about == "given") != (options.reference is not None):
            raise PluginError("reference: is for `about: given`, and needed there; give both or neither")
        change = math.inf if options.change is None else options.change
        reference = per_cable(robot, "reference", options.reference)
        roots = [math.sqrt(weight) for weight in per_cable(robot, "weights", options.weights)]
        weighted = float(options.weights is not None)
        super().__init__(
            robot,
            options,
            minimum_norm,
            parameters=[ABOUT[about], change, weighted, *reference, *roots],
            # With W rank-deficient the null space may have up to m dimensions.
            rows=null_space.form_rows(m) + 4 + n + max(null_space.work_rows(n), active_set.work_rows(m)),
        )


@kernel
def minimum_norm(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution nearest to the reference; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT.

    Also UNSUPPORTED: infinite limits have no middle.
    """
    n, m = W.shape
    if t_min.shape[0] < m or t_max.shape[0] < m:
        return BAD_INPUT
    N, box, x, active = work[:m], work[m : m + 3], work[m + 3], work[m + 4]
    rest = work[m + 5 :]
    about, change, weighted = int(parameters[0]), parameters[1], parameters[2] != 0.0
    reference = parameters[REFERENCE : REFERENCE + m]
    root = parameters[REFERENCE + m :]
    if weighted:
        scaled, low, high = rest[:n], rest[n], rest[n + 1]
        rest = rest[n + 2 :]
        for i in range(m):
            low[i], high[i] = root[i] * t_min[i], root[i] * t_max[i]
            for j in range(n):
                scaled[j, i] = W[j, i] / root[i]
        r = reduce(scaled, wrench, low, high, box, N, rest)
    else:
        r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    # A first step has nothing previous.
    window = math.isfinite(change)
    if about == PREVIOUS or window:
        for i in range(m):
            if not math.isfinite(tension[i]):
                about, window = (ZERO if about == PREVIOUS else about), False
    if window:
        for i in range(m):
            s = root[i] if weighted else 1.0
            box[1, i] = max(box[1, i], s * (tension[i] - change))
            box[2, i] = min(box[2, i], s * (tension[i] + change))
            if not box[1, i] <= box[2, i]:  # the limits themselves have moved away
                return NOT_FOUND
    if about != ZERO:
        for k in range(r):
            s = 0.0
            for i in range(m):
                if about == MIDDLE:
                    target = 0.5 * (t_min[i] + t_max[i])
                    if not math.isfinite(target):
                        return UNSUPPORTED
                else:
                    target = tension[i] if about == PREVIOUS else reference[i]
                s += N[i, k] * (root[i] * target if weighted else target)
            x[k] = s
        for i in range(m):
            for k in range(r):
                box[0, i] += N[i, k] * x[k]
    steps = nearest(N, r, box, x, tension, active, rest)
    if steps < 0:
        return NOT_FOUND if window else -steps
    if weighted:  # back to newtons
        for i in range(m):
            tension[i] = min(max(tension[i] / root[i], t_min[i]), t_max[i])
            box[0, i] /= root[i]
            for k in range(r):
                N[i, k] /= root[i]
    status = verdict(W, wrench, N, r, box, x, tension)
    return NOT_FOUND if window and status != OK else status
