"""Forward kinematics: the pose from the cable lengths. Conventions: see `cdpr.model`.

With m cables and n degrees of freedom this is a least-squares problem, over-determined where m > n. Several poses can
have the same lengths (a suspended platform also above its anchors): found is the one that a descent from the start
reaches. Pott, Cable-Driven Parallel Robots (2018), chapter 4; the damping is that of Marquardt (1963).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr import tolerances
from cdpr.cables.lines import lines
from cdpr.errors import CdprError
from cdpr.mechanics.geometry import cable_geometry
from cdpr.model.arrays import checked
from cdpr.model.cholesky import factorise, solve
from cdpr.model.jit import kernel
from cdpr.model.kernels import exponential, multiply, quaternion
from cdpr.model.robot import Array, Robot

MOST_ITERATIONS = 100
# An undamped step shorter than this, m (turns times the characteristic length), is the last one: convergence is
# quadratic, or gains three digits a step where lengths disagree by a thousandth, so that what remains is below 1e-12 m.
LAST_STEP = 1e-9
# Share of the lengths by which they may differ from those of the pose. Measured lengths differ by some thousandths
# (sag, elasticity, encoders); with more, the descent has found another minimum, or the lengths belong to no pose.
MISFIT = 0.02
# Close to the optimum the sum of squares changes by less than its round-off: a step may raise it by this share.
ROUND_OFF = 1e-10
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-4, 1e-7, 1e8


@dataclass(frozen=True, eq=False)
class Fit:
    """A pose fitted to cable lengths.

    Attributes:
        pose: (7,) position (m, world) and unit quaternion w, x, y, z.
        residual: Euclidean norm of the differences of the m lengths, m.
        covariance: (n, n) of the pose's deviation along the robot's degrees of freedom, in their order: position
            (m, world axes), rotation vector (rad, world axes). It is sigma^2 (J^T J)^-1 with J = -W^T, for independent
            errors of the lengths with standard deviation sigma; inf where the lengths leave a direction undetermined.
        iterations: linear systems solved.
        converged: whether the last step was below 1e-9 m and the lengths are those of the pose, within MISFIT; else
            `pose` is the best one found and not to be trusted.
    """

    pose: Array
    residual: float
    covariance: Array
    iterations: int
    converged: bool


def forward_kinematics(robot: Robot, lengths: Array, start: Array, *, sigma: float | None = None) -> Fit:
    """Fit the pose to measured cable lengths.

    Args:
        robot: at least as many cables as degrees of freedom. Its guide keeps the other coordinates as in `start`.
        lengths: (m,), m.
        start: (7,) pose to start from: position (m, world) and quaternion w, x, y, z.
        sigma: standard deviation of the length errors, m; None: estimated as residual / sqrt(m - n), which needs
            m > n; the covariance is nan where m = n.

    Raises CdprError where the input is wrong. A fit that does not converge raises nothing: see `Fit.converged`.
    """
    n, m = robot.n, robot.m
    if m < n:
        raise CdprError(f"robot '{robot.name}': {m} lengths do not determine {n} degrees of freedom")
    target = checked(lengths, (m,), "forward kinematics: lengths", finite=True)
    pose = checked(start, (7,), "forward kinematics: start", finite=True).copy()
    if not target.min() > 0.0:
        raise CdprError("forward kinematics: lengths must be positive")
    norm = math.sqrt(float(pose[3:] @ pose[3:]))
    if abs(norm - 1.0) > tolerances.UNIT:
        raise CdprError(f"forward kinematics: start: the quaternion has the length {norm:.6g}, it must be 1")
    if sigma is not None and not 0.0 <= sigma < math.inf:
        raise CdprError(f"forward kinematics: sigma must be a finite number of metres >= 0, not {sigma}")
    pose[3:] /= norm
    inverse = np.empty((n, n))
    count, residual = fit(lines(robot), *scales(robot), target, pose, inverse, np.empty(work_size(n, m)))
    if sigma is None:
        sigma = residual / math.sqrt(m - n) if m > n else math.nan
    fits = residual <= MISFIT * math.sqrt(float(target @ target))
    return Fit(pose, residual, sigma * sigma * inverse, abs(count), count > 0 and fits)


def scales(robot: Robot) -> tuple[NDArray[np.int64], Array]:
    """Rows of a twist (n,) that the lengths determine, and what makes each a length: 1, or the characteristic one."""
    rows = np.array(robot.rows)
    return rows, np.where(rows < 3, 1.0, robot.characteristic_length)


def work_size(n: int, m: int) -> int:
    """Floats that `fit` needs as work space."""
    return 26 + 8 * m + n * n + 2 * n


@kernel
def fit(
    lines: Array,
    rows: NDArray[np.int64],
    scale: Array,
    target: Array,
    pose: Array,
    inverse: Array,
    work: Array,
) -> tuple[int, float]:
    """Move `pose` (7,) to fit the lengths `target` (m,); write (J^T J)^-1 (n, n), inf where J is rank-deficient.

    Returns the iterations, negative where it did not converge, and the norm of the remaining differences, m. `rows`
    and `scale` (n,) are as `scales` says.

    Gauss and Newton's step, J^T J step = J^T r; damped, by a share of the diagonal, only where it does not reduce
    |r|. Turns are taken as rotation vectors in world axes, so that no attitude is singular.
    """
    n, m = rows.shape[0], lines.shape[0]
    state = work[:13]  # the twist stays zero
    trial = work[13:26]
    geometry = work[26 : 26 + 8 * m]
    A = work[26 + 8 * m : 26 + 8 * m + n * n].reshape(n, n)
    gradient = work[26 + 8 * m + n * n : 26 + 8 * m + n * n + n]
    step = work[26 + 8 * m + n * n + n : 26 + 8 * m + n * n + 2 * n]
    for i in range(13):
        state[i] = pose[i] if i < 7 else 0.0
        trial[i] = state[i]
    damping, count, converged = 0.0, 0, False
    while count < MOST_ITERATIONS and damping <= MOST_DAMPING and not converged:
        count += 1
        cost = _linearise(lines, rows, target, state, geometry, A, gradient)
        if factorise(A, damping):
            solve(A, gradient, step)
            size = 0.0
            for k in range(n):
                size += (scale[k] * step[k]) ** 2
            _move(rows, state, step, trial)
            converged = damping == 0.0 and size <= LAST_STEP * LAST_STEP
            if converged or _cost(lines, target, trial, geometry) <= cost * (1.0 + ROUND_OFF):
                for i in range(7):
                    state[i] = trial[i]
                damping = 0.1 * damping if damping > LEAST_DAMPING else 0.0
                continue
        damping = max(10.0 * damping, FIRST_DAMPING)
    for i in range(7):
        pose[i] = state[i]
    cost = _linearise(lines, rows, target, state, geometry, A, gradient)
    determined = factorise(A, 0.0)
    for k in range(n):
        for j in range(n):
            gradient[j] = 1.0 if j == k else 0.0
        solve(A, gradient, step)
        for j in range(n):
            inverse[j, k] = step[j] if determined else math.inf
    return count if converged else -count, math.sqrt(cost)


@kernel
def _cost(lines: Array, target: Array, state: Array, geometry: Array) -> float:
    """Write W, lengths and rates at `state` into `geometry` (8 m,); return the sum of squared differences."""
    m = lines.shape[0]
    length = geometry[6 * m : 7 * m]
    cable_geometry(lines, state, geometry[: 6 * m].reshape(6, m), length, geometry[7 * m :])
    cost = 0.0
    for i in range(m):
        cost += (target[i] - length[i]) ** 2
    return cost


@kernel
def _linearise(
    lines: Array, rows: NDArray[np.int64], target: Array, state: Array, geometry: Array, A: Array, gradient: Array
) -> float:
    """Write J^T J (n, n) and J^T r (n,) at `state`; return |r|^2. J = -W^T: a length shrinks along +u."""
    n, m = rows.shape[0], lines.shape[0]
    cost = _cost(lines, target, state, geometry)
    W = geometry[: 6 * m].reshape(6, m)
    length = geometry[6 * m : 7 * m]
    for k in range(n):
        s = 0.0
        for i in range(m):
            s -= W[rows[k], i] * (target[i] - length[i])
        gradient[k] = s
        for j in range(k + 1):
            s = 0.0
            for i in range(m):
                s += W[rows[k], i] * W[rows[j], i]
            A[k, j] = s
    return cost


@kernel
def _move(rows: NDArray[np.int64], state: Array, step: Array, trial: Array) -> None:
    """Write into `trial` the pose of `state` moved by the twist `step` (n,)."""
    turn = (0.0, 0.0, 0.0)
    for i in range(3):
        trial[i] = state[i]
    for k in range(rows.shape[0]):
        row = rows[k]
        if row < 3:
            trial[row] += step[k]
        elif row == 3:
            turn = (step[k], turn[1], turn[2])
        elif row == 4:
            turn = (turn[0], step[k], turn[2])
        else:
            turn = (turn[0], turn[1], step[k])
    q = multiply(exponential(turn), quaternion(state, 3))
    norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        trial[3 + i] = q[i] / norm
