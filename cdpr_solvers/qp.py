"""Minimum 2-norm within the limits: min sum w_i (t_i - ref_i)^2 with W t = wrench, t_min <= t <= t_max."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import PluginError
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.arrays import real, reals
from cdpr.native.bind import bind
from cdpr.plugins import CompiledSolver
from cdpr.tension.status import Status
from cdpr_solvers.options import QpOptions, per_cable

ZERO, MIDDLE, PREVIOUS, GIVEN = range(4)
ABOUT = {"zero": ZERO, "middle": MIDDLE, "previous": PREVIOUS, "given": GIVEN}


class MinimumNorm(CompiledSolver):
    """Convex quadratic program, exact for any number of cables and any rank, and continuous (Bruckmann et al. 2006).

    With t = c + N x, c the solution of least norm and N an orthonormal basis of the null space, |t|^2 = |c|^2 + |x|^2.
    So the optimum is the point of least norm in a polytope in m - n dimensions. A reference moves the origin to N^T
    ref. Weights scale the cables: with D = diag(sqrt(w)), D t solves the problem of W D^-1.

    `weights: stiffness` uses l_i / (E A)_i, the compliance of each cable at the home pose of the robot. The objective
    is then twice the elastic energy, sum t_i^2 / k_i, so that stiff cables carry more.

    `change` narrows the limits to t_previous +- change. If no distribution lies within this window, the status is
    NOT_FOUND. The first step has no previous tensions: `about: previous` is then about zero, and any change is allowed.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        if not isinstance(options, QpOptions):  # a solver derived from this one, with other options or none
            options = QpOptions()
        about = options.about
        if (about == "given") != (options.reference is not None):
            raise PluginError("reference: is for `about: given`, and needed there; give both or neither")
        change = math.inf if options.change is None else options.change
        reference = per_cable(robot, "reference", options.reference)
        weights = compliance(robot) if options.weights == "stiffness" else per_cable(robot, "weights", options.weights)
        roots = [math.sqrt(weight) for weight in weights]
        super().__init__(
            robot,
            options,
            "minimum_norm",
            parameters={
                "about": ABOUT[about],
                "change": change,
                "weighted": int(options.weights is not None),
                "reference": np.array(reference),
                "root": np.array(roots),
            },
            follows=about == "previous" or options.change is not None,
        )


def compliance(robot: Robot) -> list[float]:
    """Return l_i / (E A)_i of each cable at the home pose, relative to the largest; raise PluginError if unknown."""
    soft = [cable.axial_stiffness for cable in robot.cables]
    if robot.home is None or None in soft:
        missing = "home" if robot.home is None else "cable: {axial_stiffness: ...} of each cable"
        raise PluginError(f"weights: stiffness needs the robot's {missing}; robot '{robot.name}' has none")
    length = lengths(robot, make_state(robot.home[:3], robot.home[3:]))
    values = [float(size / k) for size, k in zip(length, soft, strict=True) if k is not None]
    return [value / max(values) for value in values]


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
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        about: reference: "zero", "middle" of the limits, "previous" or "given".
        reference: (m,) reference for "given" [N].
        previous: (m,) tensions of the previous step [N], None in the first step.
        change: largest change of a tension from the previous step [N].
        weights: (m,) positive weights, by default all 1.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions are admissible,
        NOT_FOUND, UNSUPPORTED if an infinite limit has no middle, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match, or `about` is unknown.

    Example:
        >>> minimum_norm_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    if about not in ABOUT:
        raise ValueError(f"about: unknown value '{about}'; allowed: {', '.join(ABOUT)}.")
    arrays = reals(matrix=matrix, wrench=wrench, tension_min=tension_min, tension_max=tension_max)
    m = arrays["tension_min"].shape
    arrays["reference"] = np.zeros(m) if reference is None else real(reference, "reference")
    arrays["root"] = np.sqrt(np.ones(m) if weights is None else real(weights, "weights"))
    tension = np.full(m, np.nan) if previous is None else real(previous, "previous").copy()
    values = {"about": ABOUT[about], "change": change, "weighted": int(weights is not None)}
    status = Status(bind("minimum_norm", **arrays, **values, tension=tension, status=np.empty(1))())
    if status != Status.OK:
        tension[:] = np.nan
    return tension, status
