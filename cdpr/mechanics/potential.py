"""Potential energy of a platform on cables with given unwound lengths or tensions, and unwound lengths at rest.

The energy is that of the weight and of the stretched cables; a slack cable has none. Cables that sag also have that of
their own weight. Derivatives are taken with respect to motions of the origin and rotation vectors in world axes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.threads import in_threads
from cdpr.cables import chain_of
from cdpr.cables.tables import chain_table, line_table
from cdpr.mechanics.forward_kinematics import scales
from cdpr.model import Robot, rotations
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.native.bind import bind

DOWN = (0.0, 0.0, -9.81)  # m/s^2


class Potential:
    """Potential energy of a robot's platform.

    Values are in scaled coordinates along the degrees of freedom: rotations are multiplied by the characteristic
    length, so that gradients are in N and the Hessian in N/m.

    Args:
        robot: geometry, mass and cables.
        gravity: (3,) gravity [m/s^2], world axes.
        unwound: (m,) unwound lengths [m]; NaN for cables with a given tension.
        tension: (m,) given tensions [N]; NaN for cables with a given length.

    Attributes:
        bent: (m,) True for cables that sag.
        spring: (m,) 1 for cables with a given length that stretch, 2 for cables with a given tension that sag.
        rigid: (m,) True for cables with a given length that do not stretch.
        force: (m,) tension [N] of other cables; multipliers of rigid ones.
        penalty: (m,) stiffness [N/m] of rigid ones; 0 for a constant force.
        weight: weight of the platform [N].
        size: extent of the anchors on the frame, or longest cable if larger [m].
        energy, gradient, hessian: value [J], (n,) and (n, n) at the last evaluated pose.
        matrix, length, tension, slope, shift: wrench matrix (6, m), and lengths [m], tensions [N] and their derivatives
            with length and unwound length [N/m] of the cables (m,), at the last evaluated pose.
        response: (6, m) derivatives of the wrench with the unwound length, or for given tensions with these.
    """

    def __init__(self, robot: Robot, gravity: ArrayLike, unwound: Array, tension: Array) -> None:
        m, given = robot.m, ~np.isnan(unwound)
        chains = [chain_of(robot, cable) for cable in robot.cables]
        stretches = np.array([chain.stretches for chain in chains])
        self.bent = np.array([chain.span.bends for chain in chains])
        self.robot, self.rigid = robot, given & ~stretches
        self.spring: NDArray[np.int64] = np.where(given, stretches, 2 * self.bent).astype(np.int64)
        self.unwound = np.where(given, unwound, 1.0)
        self.force, self.penalty = np.where(given, 0.0, tension), np.zeros(m)
        self.gravity = checked(gravity, (3,), "gravity", finite=True).copy()
        self.weight = robot.platform.mass * float(np.linalg.norm(self.gravity))
        self.size = max(
            float(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0))), float(self.unwound[given].max(initial=0.0))
        )
        self.size = self.size or 1.0
        self.rows, self.scale = scales(robot)
        self.matrix, self.length, self.tension = np.empty((6, m)), np.empty(m), np.empty(m)
        self.slope, self.shift, self.response = np.empty(m), np.empty(m), np.empty((6, m))
        self._pose, self._energy, self._gradient, self._hessian = (
            np.empty(7),
            np.empty(1),
            np.empty(6),
            np.empty((6, 6)),
        )
        self._factors = 1.0 / np.outer(self.scale, self.scale)
        self._block = np.ix_(self.rows, self.rows)
        self._call = bind(
            "potential",
            lines=line_table(robot),
            chains=chain_table(robot),
            inertial=robot.inertial,
            gravity=self.gravity,
            pose=self._pose,
            spring=self.spring,
            unwound=self.unwound,
            force=self.force,
            penalty=self.penalty,
            energy=self._energy,
            gradient=self._gradient,
            hessian=self._hessian,
            matrix=self.matrix,
            length=self.length,
            tension=self.tension,
            slope=self.slope,
            shift=self.shift,
            response=self.response,
        )

    def evaluate(self, pose: Array) -> tuple[float, Array, Array]:
        """Return energy [J], gradient (n,) [N] and Hessian (n, n) [N/m] at a pose (7,); NaN where cables have none."""
        self._pose[:] = pose
        self._call()
        gradient = self._gradient[self.rows] / self.scale
        return float(self._energy[0]), gradient, self._hessian[self._block] * self._factors

    def defined(self, pose: Array) -> bool:
        """Return True if all cables have a length and a path over their pulley at a pose (7,)."""
        self.evaluate(pose)
        return bool(np.isfinite(self._hessian).all())

    def columns(self) -> Array:
        """Return the scaled wrench matrix (n, m) at the last evaluated pose."""
        return np.asarray(self.matrix[self.rows] / self.scale[:, None])

    def load(self) -> float:
        """Return the force [N] to which residuals are compared: weight, or largest tension at the last pose."""
        return max(self.weight, float(np.abs(self.tension).max(initial=0.0)))

    def moved(self, pose: Array, step: Array) -> Array:
        """Return a pose (7,) moved by a scaled step (n,)."""
        twist = np.zeros(6)
        twist[self.rows] = step / self.scale
        found = pose.copy()
        found[:3] += twist[:3]
        angle = float(np.linalg.norm(twist[3:]))
        if angle > 0.0:
            q = rotations.multiply(rotations.from_axis_angle(twist[3:] / angle, angle), pose[3:])
            found[3:] = q / np.linalg.norm(q)
        return found


def rest_lengths(
    robot: Robot, poses: ArrayLike, tension: ArrayLike, *, gravity: ArrayLike = DOWN, jobs: int | None = None
) -> Array:
    """Return the unwound lengths (K, m) [m], exits included, of cables at rest with given tensions.

    Args:
        robot: the robot. A cable that does not stretch is as long as its path.
        poses: (K, 7) positions [m] and quaternions w, x, y, z.
        tension: (K, m) tensions at the winches [N]. NaN is returned for cables that sag and have less than their least
            tension.
        gravity: (3,) gravity [m/s^2], world axes, for cables that sag.
        jobs: number of threads. It does not change the result.

    Raises:
        CdprError: if an argument has the wrong kind or shape.
    """
    given = checked(poses, (None, 7), "poses")
    pulled = checked(tension, (len(given), robot.m), "tension")
    found = np.empty((len(given), robot.m))
    down = checked(gravity, (3,), "gravity", finite=True)
    fixed = {"lines": line_table(robot), "chains": chain_table(robot), "gravity": down}

    def write(cut: slice) -> None:
        bind("rest_lengths", **fixed, poses=given[cut], tension=pulled[cut], unwound=found[cut]).unlocked()

    in_threads(len(given), write, jobs)
    return found
