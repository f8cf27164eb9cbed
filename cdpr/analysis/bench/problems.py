"""Benchmark problems of one robot: random poses and loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cdpr.analysis.bench.adversaries import Adversaries
from cdpr.analysis.bench.continuity import Path
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot, rotations
from cdpr.model.robot import DOF_NAMES, Array, frozen_array

GRAVITY = frozen_array([0.0, 0.0, -9.81])  # m/s^2, world axes

# Share of the way from home to the outermost anchors. Most robots cannot hold their load that far out, so that some
# problems are infeasible.
REACH = 0.7

TILT = np.radians(10.0)  # rad, about each free axis
LOAD = 0.2  # largest random force as a share of the weight; moment likewise, times the characteristic length

# One problem in HEAVY_EVERY has its wrench multiplied, as by a payload, up to a weight of HEAVIEST times the sum of all
# upper tension limits. Robots with limits far above their weight would be too easy otherwise.
HEAVY_EVERY, HEAVIEST = 5, 0.5


@dataclass(frozen=True, eq=False)
class Problems:
    """K problems W t = wrench, t_min <= t <= t_max, of a robot with n degrees of freedom and m cables.

    If `limits` is None, the robot's apply; if `unit` is None, it is 1 N.
    """

    robot: Robot
    W: Array  # (K, n, m)
    wrench: Array  # (K, n)
    limits: tuple[Array, Array] | None = None  # lowest and highest tensions, each (K, m), N
    unit: Array | None = None  # (K,), N: reference for smaller wrenches and limits

    def __len__(self) -> int:
        return len(self.W)

    @property
    def weights(self) -> Array:
        """Row weights (n,): 1 for forces, 1 / characteristic length for moments."""
        return np.repeat([1.0, 1.0 / self.robot.characteristic_length], 3)[self.robot.rows]

    @property
    def t_min(self) -> Array:
        """Lowest tensions (K, m), N."""
        return self._limit(0)

    @property
    def t_max(self) -> Array:
        """Highest tensions (K, m), N."""
        return self._limit(1)

    def _limit(self, which: int) -> Array:
        if self.limits is not None:
            return self.limits[which]
        return np.broadcast_to((self.robot.tension_min, self.robot.tension_max)[which], (len(self), self.robot.m))

    @property
    def units(self) -> Array:
        """References for smaller wrenches and limits, (K,), N."""
        return np.ones(len(self)) if self.unit is None else self.unit

    def first(self, count: int) -> Problems:
        """Return the first `count` problems."""
        limits = None if self.limits is None else (self.limits[0][:count], self.limits[1][:count])
        unit = None if self.unit is None else self.unit[:count]
        return Problems(self.robot, self.W[:count], self.wrench[:count], limits, unit)


def box(robot: Robot) -> Array:
    """Return the lowest and highest position (2, 3), m, of a box around home.

    Along each free axis, the box extends `REACH` of the way from home to the outermost frame anchor on either side. If
    no anchor lies on one side, as below a suspended robot, the other side's extent applies. Held axes keep home's
    value.
    """
    home = home_pose(robot)[0][:3]
    offset = robot.anchors[:, :3] - home
    below, above = np.maximum(-offset.min(axis=0), 0.0), np.maximum(offset.max(axis=0), 0.0)
    below, above = np.where(below > 0.0, below, above), np.where(above > 0.0, above, below)
    free = np.array([name in robot.dof for name in DOF_NAMES[:3]])
    return np.array([home - free * REACH * below, home + free * REACH * above])


def random_pose(robot: Robot, rng: np.random.Generator) -> Array:
    """Return a pose (7,), position (m) and quaternion, in the box, tilted by up to `TILT` about each free axis."""
    low, high = box(robot)
    position = low + (high - low) * rng.uniform(size=3)
    free = np.array([name in robot.dof for name in DOF_NAMES[3:]])
    turn = rotations.from_rpy(*(free * rng.uniform(-TILT, TILT, 3)))
    return np.concatenate([position, rotations.multiply(turn, home_pose(robot)[0][3:])])


def make_problems(robot: Robot, count: int, seed: int) -> Problems:
    """Return random static problems: the weight, a random force and moment, and sometimes a payload.

    Problem k depends only on the robot, the seed and k. Magnitudes are uniform up to their largest value, and
    directions are uniform on the sphere.
    """
    W, wrench = np.empty((count, robot.n, robot.m)), np.empty((count, robot.n))
    weight = robot.platform.mass * float(np.linalg.norm(GRAVITY))
    largest = LOAD * weight * np.repeat([1.0, robot.characteristic_length], 3)
    heaviest = max(1.0, HEAVIEST * float(robot.tension_max.sum()) / weight)
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        pose = random_pose(robot, rng)
        state = make_state(pose[:3], pose[3:])
        direction = rng.normal(size=(2, 3))
        direction *= rng.uniform(size=(2, 1)) / np.linalg.norm(direction, axis=1, keepdims=True)
        load = required_wrench(robot, state, GRAVITY) + largest * direction.ravel()
        if k % HEAVY_EVERY == 0:
            load *= rng.uniform(1.0, heaviest)
        W[k], wrench[k] = wrench_matrix(robot, state)[robot.rows], load[robot.rows]
    W.flags.writeable = wrench.flags.writeable = False  # no solver can change the problems of the next one
    return Problems(robot, W, wrench)


def hard_problems(found: Adversaries) -> Problems:
    """Return adversarial problems, each with its own largest tension as unit."""
    return Problems(found.robot, found.W, found.wrench, (found.low, found.high), np.abs(found.high).max(axis=1))


def make_paths(robot: Robot, count: int, seed: int) -> list[Path]:
    """Return random straight paths in the box, feasible everywhere, half of them near the lower limits."""
    paths = []
    low, span = robot.tension_min, robot.tension_max - robot.tension_min
    for k in range(count):
        rng = np.random.default_rng([seed, k, 1])
        poses = np.array([random_pose(robot, rng) for _ in range(2)])
        reach = rng.uniform(0.05, 1.0) if k % 2 else 0.05
        paths.append(Path(robot, poses, low + span * reach * rng.uniform(size=(2, robot.m))))
    return paths
