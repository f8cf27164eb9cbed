"""Minimum 2-norm within the limits: min sum w_i (t_i - ref_i)^2 with W t = wrench, t_min <= t <= t_max."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.errors import PluginError
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.model import Robot
from cdpr.model.address import address, caller
from cdpr.model.jit import kernel, small
from cdpr.model.lanes import bits, side_by_side
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import CompiledSolver
from cdpr.tension import active_set, null_space, row_space
from cdpr.tension.active_set import FEASIBILITY_TOLERANCE, least, nearest
from cdpr.tension.null_space import common, complete, reduce, reduce_to_point
from cdpr.tension.row_space import BY_ROWS as BY_ROWS_KERNEL
from cdpr.tension.row_space import worthwhile
from cdpr.tension.status import BAD_INPUT, INFEASIBLE, NOT_FOUND, OK, UNSUPPORTED, Status
from cdpr.tension.verdict import ROUND_OFF, compared, verdict
from cdpr_solvers.options import QpOptions, per_cable

ZERO, MIDDLE, PREVIOUS, GIVEN = range(4)
ABOUT = {"zero": ZERO, "middle": MIDDLE, "previous": PREVIOUS, "given": GIVEN}

# A reference this many times as large as the tensions makes its round-off count (2^-52 of it, against the share of the
# wrench that answers may leave); of a nearer one it does not, and where it finds nothing there is nothing.
FAR = 1e3

# Parameters: about, largest change (inf: any), whether weighted, the address of `nearest_by_rows` where that is worth
# while, else 0 (few robots have so many cables, and it takes long to compile), m references, m roots of weights.
BY_ROWS, REFERENCE = 3, 4

nearest_by_rows = caller(BY_ROWS_KERNEL)


class MinimumNorm(CompiledSolver):
    """Exact for any number of cables and any rank, continuous; a convex quadratic program (Bruckmann et al. 2006).

    With t = c + N x, c the solution of least norm and N an orthonormal basis of the null space, |t|^2 = |c|^2 + |x|^2:
    the optimum is the point of least norm in a polytope in m - n dimensions. A reference moves the origin to N^T ref;
    weights scale the cables: with D = diag(sqrt(w)), D t solves the problem of W D^-1.

    `weights: stiffness` takes l_i / (E A)_i, the compliance of each cable at the robot's home: what is least is then
    twice the elastic energy, sum t_i^2 / k_i, so that stiff cables carry more.

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
        weights = compliance(robot) if options.weights == "stiffness" else per_cable(robot, "weights", options.weights)
        roots = [math.sqrt(weight) for weight in weights]
        weighted = float(options.weights is not None)
        many = bool(worthwhile(n, m))
        plain = about in ("zero", "previous") and options.weights is None and not many
        by_rows = address(row_space.nearest_by_rows, BY_ROWS_KERNEL) if many else 0.0
        super().__init__(
            robot,
            options,
            minimum_norm,
            lanes=minimum_norms if plain else None,
            follows=about == "previous" or options.change is not None,
            parameters=[ABOUT[about], change, weighted, by_rows, *reference, *roots],
            rows=_rows(n, m),
        )


def compliance(robot: Robot) -> list[float]:
    """Return l_i / (E A)_i of each cable at the robot's home, relative to the largest; PluginError where unknown."""
    soft = [cable.axial_stiffness for cable in robot.cables]
    if robot.home is None or None in soft:
        missing = "home" if robot.home is None else "cable: {axial_stiffness: ...} of each cable"
        raise PluginError(f"weights: stiffness needs the robot's {missing}; robot '{robot.name}' has none")
    length = lengths(robot, make_state(robot.home[:3], robot.home[3:]))
    values = [float(size / k) for size, k in zip(length, soft, strict=True) if k is not None]
    return [value / max(values) for value in values]


@small
@kernel
def _rows(n: int, m: int) -> int:
    """Rows of work space; the null space of a rank-deficient W may have up to m dimensions."""
    return null_space.form_rows(m) + 5 + n + max(null_space.work_rows(n), active_set.work_rows(m))


@kernel
def minimum_norm(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution nearest to the reference; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT.

    Also UNSUPPORTED: infinite limits have no middle.
    """
    n, m = W.shape
    if work.shape[0] < _rows(n, m) or work.shape[1] < max(n, m) or parameters.shape[0] != REFERENCE + 2 * m:
        return BAD_INPUT  # made for another robot
    if t_min.shape[0] < m or t_max.shape[0] < m:
        return BAD_INPUT
    N, box, x, active, target = work[:m], work[m : m + 3], work[m + 3], work[m + 4], work[m + 5, :m]
    A, low, high, rest = work[m + 6 : m + 6 + n], work[m + n + 6, :m], work[m + n + 7, :m], work[m + n + 8 :]
    about, change, weighted = int(parameters[0]), parameters[1], parameters[2] != 0.0
    reference = parameters[REFERENCE : REFERENCE + m]
    root = parameters[REFERENCE + m :]
    # A first step has nothing previous.
    window = math.isfinite(change)
    if about == PREVIOUS or window:
        for i in range(m):
            if not math.isfinite(tension[i]):
                about, window = (ZERO if about == PREVIOUS else about), False
    by_rows = parameters[BY_ROWS]
    plain = not (weighted or window or about != ZERO or by_rows != 0.0)
    if not plain:
        for i in range(m):
            s = root[i] if weighted else 1.0
            low[i], high[i], target[i] = s * t_min[i], s * t_max[i], 0.0
            if about == MIDDLE:
                target[i] = s * (0.5 * (t_min[i] + t_max[i]))
                if not math.isfinite(target[i]):
                    return UNSUPPORTED
            elif about != ZERO:
                target[i] = s * (tension[i] if about == PREVIOUS else reference[i])
            if window:
                if not t_min[i] <= t_max[i]:
                    return BAD_INPUT
                low[i] = max(low[i], s * (tension[i] - change))
                high[i] = min(high[i], s * (tension[i] + change))
                if not low[i] <= high[i]:  # the limits themselves have moved away
                    return NOT_FOUND
            for j in range(n):
                A[j, i] = W[j, i] / s if weighted else W[j, i]
    status, lost, far = NOT_FOUND, OK, 0.0
    for again in range(2):
        r, judged = 0, False
        if by_rows != 0.0:
            status = nearest_by_rows(by_rows, A, wrench, low, high, target, tension, N, box, rest)
        if by_rows == 0.0 or status == NOT_FOUND:
            if plain:
                r = reduce_to_point(W, wrench, t_min, t_max, box, N, rest)
            else:
                r = reduce(A, wrench, low, high, box, N, rest)
            if plain and r >= 0:
                excess, scale = least(box, tension, active)
                if excess <= FEASIBILITY_TOLERANCE * scale:  # as mostly: nothing is in the way, and N not needed
                    return verdict(W, wrench, N, 0, box, x, tension)
                complete(n, r, box, N, rest)
            if r < 0:
                return NOT_FOUND if window and r == -INFEASIBLE else -r
            if about != ZERO:
                for k in range(r):
                    x[k] = 0.0
                    for i in range(m):
                        x[k] += N[i, k] * target[i]
                for i in range(m):
                    for k in range(r):
                        box[0, i] += N[i, k] * x[k]
            status = -min(nearest(N, r, box, x, tension, active, rest), 0)
            judged = status == OK
        found = status == OK
        if found and weighted:  # back to newtons
            for i in range(m):
                tension[i] = min(max(tension[i] / root[i], t_min[i]), t_max[i])
                box[0, i] /= root[i]
                for k in range(r):
                    N[i, k] /= root[i]
        if judged:
            status = verdict(W, wrench, N, r, box, x, tension)
        if again or about == ZERO or status not in (INFEASIBLE, NOT_FOUND):
            break
        # The round-off of a target far from the limits, such as the middle of one that is as good as none, may be as
        # large as the tensions. What was found is near the optimum: asked about that, it is gone.
        lost = OK if found else status
        for i in range(m):
            s = root[i] if weighted else 1.0
            far = max(far, abs(target[i]) / s)
            target[i] = s * tension[i] if found else 0.0
    if lost != OK and status == OK:  # there are some, but the nearest ones are lost
        size = 0.0
        for i in range(m):
            size = max(size, abs(tension[i]))
        status = NOT_FOUND if far > FAR * size else lost
    return NOT_FOUND if window and status == INFEASIBLE else status


@kernel
def minimum_norms(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Answer those of eight problems, none with a step before, that no limit holds up, as `minimum_norm` does."""
    n, m = W.shape[0], W.shape[1]
    if work.shape[0] < _rows(n, m) or work.shape[1] < max(n, m) or parameters[BY_ROWS] != 0.0:
        return 0
    if parameters[0] not in (ZERO, PREVIOUS) or parameters[2] != 0.0:  # of the former there is none
        return 0
    return _unhindered(
        side_by_side(W),
        side_by_side(wrench),
        side_by_side(t_min),
        side_by_side(t_max),
        side_by_side(tension),
        side_by_side(work),
    )


@kernel
def _unhindered(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, work: Array) -> int:
    """Write the tensions of least norm; return of which lanes `nearest` and `verdict` let them be."""
    n, m = W.shape
    N, box, x, active, rest = work[:m], work[m : m + 3], work[m + 3], work[m + 4], work[m + 5 :]
    if reduce_to_point(W, wrench, t_min, t_max, box, N, rest) != m - n:  # of another rank, or with locked cables
        return 0
    excess, scale = least(box, tension, active)
    breach, size = compared(N, 0, box, x, tension)
    found = common(n, m, t_min, t_max, rest)
    return bits(found & (excess <= FEASIBILITY_TOLERANCE * scale) & (breach <= ROUND_OFF * size))


def minimum_norm_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    *,
    about: str = "zero",
    reference: ArrayLike | None = None,
    previous: ArrayLike | None = None,
    change: float = math.inf,
    weights: ArrayLike | None = None,
) -> tuple[Array, Status]:
    """Compute the admissible tensions that minimise sum w_i (t_i - ref_i)^2.

    Bruckmann et al. (2006).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        about: The reference: "zero", "middle" of the limits, "previous" or "given".
        reference: (m,) N, for "given".
        previous: (m,) N, tensions of the step before; None in a first step.
        change: Largest change of a tension from the step before, N.
        weights: (m,), positive; None for 1.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE where none are admissible, NOT_FOUND,
        UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match, or `about` is unknown.

    Example:
        >>> minimum_norm_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    if about not in ABOUT:
        raise ValueError(f"about: unknown value '{about}'; allowed: {', '.join(ABOUT)}.")
    given = {"matrix": matrix, "wrench": wrench, "tension_min": tension_min, "tension_max": tension_max}
    arrays = {name: np.array(value, dtype=np.float64) for name, value in given.items()}
    m = arrays["tension_min"].shape
    arrays["reference"] = np.array(np.zeros(m) if reference is None else reference, dtype=np.float64)
    arrays["root"] = np.sqrt(np.array(np.ones(m) if weights is None else weights, dtype=np.float64))
    tension = np.array(np.full(m, np.nan) if previous is None else previous, dtype=np.float64)
    values = {"about": ABOUT[about], "change": change, "weighted": int(weights is not None)}
    status = Status(bind("minimum_norm", **arrays, **values, tension=tension, status=np.empty(1))())
    if status != Status.OK:
        tension[:] = np.nan
    return tension, status
