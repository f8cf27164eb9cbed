"""Forward kinematics, the pose from the cable lengths. See `cdpr.model` for the conventions.

For m cables and n degrees of freedom, this is a least-squares problem, over-determined if m > n. Several poses can have
the same lengths: for example, a suspended platform and its mirror image above the anchors. The result is the pose that
a descent from the start reaches. Cables are straight: with lengths of cables that sag or stretch, use
`cdpr.mechanics.equilibrium`. See Pott, Cable-Driven Parallel Robots (2018), chapter 4; the damping is that of
Marquardt (1963).
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.cables.tables import line_table
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind

# Largest residual of a fit, as a share of the lengths. Measured lengths deviate by some thousandths (sag, elasticity,
# encoders). A larger residual means another local minimum, or lengths that belong to no pose.
MISFIT = 0.02

# Without the suspect cable, at most this share of MISFIT remains, and of the residual without any other cable.
EXPLAINED = 0.1


@dataclass(frozen=True, eq=False)
class Fit:
    """Pose fitted to cable lengths.

    Attributes:
        pose: (7,) position [m] and unit quaternion w, x, y, z, in the world frame.
        residual: Euclidean norm of the m length differences [m].
        covariance: (n, n) covariance of the pose along the degrees of freedom of the robot, in their order: position
            [m] and rotation vector [rad], in world axes. It is sigma^2 (J^T J)^-1 with J = -W^T, for independent length
                errors
            with the standard deviation sigma; infinite if the lengths leave a direction undetermined.
        iterations: number of linear systems solved.
        converged: True if the last step was below 1e-9 m and the residual is within MISFIT. Otherwise, `pose` is the
            best pose found and not reliable.
        suspect: index of the cable without which the other lengths fit, None if there is none or more than one. To find
            it takes at least two more cables than degrees of freedom.
    """

    pose: Array
    residual: float
    covariance: Array
    iterations: int
    converged: bool
    suspect: int | None = None


def forward_kinematics(robot: Robot, lengths: Array, start: Array, *, sigma: float | None = None) -> Fit:
    """Fit the pose to measured cable lengths, those of straight cables.

    For unwound lengths of cables that stretch or sag, compute the pose at rest instead (`cdpr.equilibrium`).

    Args:
        robot: robot with at least as many cables as degrees of freedom. Its guide keeps the other coordinates of
            `start`.
        lengths: (m,) lengths [m].
        start: (7,) initial pose: position [m] and quaternion w, x, y, z, in the world frame.
        sigma: standard deviation of the length errors [m]. By default, it is estimated as residual / sqrt(m - n); the
            covariance is then NaN if m = n.

    Raises:
        CdprError: if the input is wrong. A fit that does not converge raises no error: see `Fit.converged`.
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
    given = pose
    count, pose, inverse, residual = _fitter(robot).fit(target, given)
    if sigma is None:
        sigma = residual / math.sqrt(m - n) if m > n else math.nan
    fits = residual <= MISFIT * math.sqrt(float(target @ target))
    suspect = None if fits else suspect_length(robot, target, given)
    return Fit(pose, residual, sigma * sigma * inverse, abs(count), count > 0 and fits, suspect)


def suspect_length(robot: Robot, target: Array, start: Array) -> int | None:
    """Return the only cable without which the lengths (m,) [m] fit, searched from a pose (7,); None if there is none.

    With fewer than two cables more than degrees of freedom, the others always fit.
    """
    if robot.m < robot.n + 2:
        return None
    rests = []
    for i in range(robot.m):
        others = [k for k in range(robot.m) if k != i]
        fitter = _Fitter(robot.replace(cables=[robot.cables[k] for k in others]))
        count, _, _, rest = fitter.fit(target[others], start)
        rests.append(rest if count > 0 else math.inf)
    first, second = (int(i) for i in np.argsort(rests)[:2])
    fits = rests[first] <= EXPLAINED * MISFIT * math.sqrt(float(target @ target))
    return first if fits and rests[first] <= EXPLAINED * rests[second] else None


def scales(robot: Robot) -> tuple[NDArray[np.int64], Array]:
    """Return the rows (n,) of a twist that the lengths determine, and their scales.

    The scale is 1 for a translation and the characteristic length for a rotation.
    """
    rows = np.array(robot.rows)
    return rows, np.where(rows < 3, 1.0, robot.characteristic_length)


class _Fitter:
    """Operation bound to the arrays of one robot."""

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
        """Return the iterations, negative without convergence; the pose (7,); (J^T J)^-1 (n, n); the residual [m]."""
        self._target[:], self._pose[:] = target, start
        count = self._call()
        return count, self._pose.copy(), self._inverse.copy(), float(self._residual[0])


_last = threading.local()  # consecutive fits are often fits of one robot


def _fitter(robot: Robot) -> _Fitter:
    if getattr(_last, "robot", None) is not robot:
        _last.fitter, _last.robot = _Fitter(robot), robot
    fitter: _Fitter = _last.fitter
    return fitter
