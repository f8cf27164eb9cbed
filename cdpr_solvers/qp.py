"""Minimum 2-norm within the limits: min sum w_i (t_i - ref_i)^2 with W t = wrench, t_min <= t <= t_max."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.errors import PluginError
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import CompiledSolver
from cdpr.tension.status import Status
from cdpr_solvers.options import QpOptions, per_cable

ZERO, MIDDLE, PREVIOUS, GIVEN = range(4)
ABOUT = {"zero": ZERO, "middle": MIDDLE, "previous": PREVIOUS, "given": GIVEN}


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
        if not isinstance(options, QpOptions):  # a solver built upon this one, with options of its own or none
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
    """Return l_i / (E A)_i of each cable at the robot's home, relative to the largest; PluginError where unknown."""
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
