"""Forward kinematics: the pose from the cable lengths. Conventions: see `cdpr.model`.

With m cables and n degrees of freedom this is a least-squares problem, over-determined where m > n. Several poses can
have the same lengths (a suspended platform also above its anchors): found is the one that a descent from the start
reaches. Pott, Cable-Driven Parallel Robots (2018), chapter 4; the damping is that of Marquardt (1963).
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr import tolerances
from cdpr.cables.tables import line_table
from cdpr.errors import CdprError
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind

# Share of the lengths by which they may differ from those of the pose. Measured lengths differ by some thousandths
# (sag, elasticity, encoders); with more, the descent has found another minimum, or the lengths belong to no pose.
MISFIT = 0.02


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
    count, pose, inverse, residual = _fitter(robot).fit(target, pose)
    if sigma is None:
        sigma = residual / math.sqrt(m - n) if m > n else math.nan
    fits = residual <= MISFIT * math.sqrt(float(target @ target))
    return Fit(pose, residual, sigma * sigma * inverse, abs(count), count > 0 and fits)


def scales(robot: Robot) -> tuple[NDArray[np.int64], Array]:
    """Rows of a twist (n,) that the lengths determine, and what makes each a length: 1, or the characteristic one."""
    rows = np.array(robot.rows)
    return rows, np.where(rows < 3, 1.0, robot.characteristic_length)


class _Fitter:
    """The operation bound to arrays for one robot."""

    def __init__(self, robot: Robot) -> None:
        n, m = robot.n, robot.m
        self._target, self._pose, self._inverse, self._residual = (
            np.empty(m),
            np.empty(7),
            np.empty((n, n)),
            np.empty(1),
        )
        rows, scale = scales(robot)
        self._call = bind(
            "forward_kinematics",
            lines=line_table(robot),
            rows=rows,
            scale=scale,
            target=self._target,
            pose=self._pose,
            inverse=self._inverse,
            residual=self._residual,
        )

    def fit(self, target: Array, start: Array) -> tuple[int, Array, Array, float]:
        """Return iterations, negative without convergence; the pose (7,); (J^T J)^-1 (n, n); the residual, m."""
        self._target[:], self._pose[:] = target, start
        count = self._call()
        return count, self._pose.copy(), self._inverse.copy(), float(self._residual[0])


_last = threading.local()  # robots are fitted many times in a row


def _fitter(robot: Robot) -> _Fitter:
    if getattr(_last, "robot", None) is not robot:
        _last.fitter, _last.robot = _Fitter(robot), robot
    fitter: _Fitter = _last.fitter
    return fitter
