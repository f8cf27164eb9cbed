"""Robots, states and problems of the checks, and their reference motion. All seeds are fixed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cdpr.analysis.bench import adversaries
from cdpr.analysis.bench.continuity import Path
from cdpr.mechanics import dynamics, kinematics
from cdpr.model import Cable, Platform, Robot, rotations
from cdpr.model.robot import DOF_NAMES, Array, frozen_array

GRAVITY = frozen_array([0.0, 0.0, -9.81])
NO_GRAVITY = frozen_array([0.0, 0.0, 0.0])


def make_robot(
    anchors: Array,
    *,
    mass: float = 50.0,
    inertia: Array | None = None,
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0),
    limits: tuple[float, float] = (1.0, 1000.0),
    dof: tuple[str, ...] = DOF_NAMES,
) -> Robot:
    """Return a robot from anchors (m, 6)."""
    inertia = np.diag([2.0, 3.0, 4.0]) if inertia is None else inertia
    platform = Platform(mass, frozen_array(inertia), frozen_array(center_of_mass))
    cables = tuple(Cable(row[:3], row[3:], *limits) for row in anchors)
    return Robot(platform, cables, dof, name="sample")


def crossed(m: int) -> Array:
    """Return irregular, crossed anchors (m, 6) from the corners of a 4 m cube to a small box, with redundancy."""
    rng = np.random.default_rng(m)
    corners = np.array([[x, y, z] for x in (-2, 2) for y in (-2, 2) for z in (0, 4)], dtype=float)
    anchors = np.empty((m, 6))
    for i in range(m):
        corner = corners[i % 8]
        anchors[i, :3] = corner + rng.uniform(-0.3, 0.3, 3)
        sign = np.sign(corner - [0, 0, 2]) * ([-1, 1, 1] if i % 2 else [1, -1, -1])
        anchors[i, 3:] = sign * [0.25, 0.2, 0.15] + rng.uniform(-0.03, 0.03, 3)
    return anchors


@lru_cache
def free() -> Robot:
    """Return a robot with eight cables, a centre of mass off the origin, and all products of inertia."""
    R = rotations.matrix(rotations.from_rpy(0.4, -0.7, 1.1))
    inertia = R @ np.diag([2.0, 3.0, 4.0]) @ R.T
    return make_robot(crossed(8), inertia=(inertia + inertia.T) / 2, center_of_mass=(0.05, -0.03, 0.1))


def laden(robot: Robot) -> Robot:
    """Return the robot with another mass, centre of mass and inertia of its platform."""
    platform = robot.platform
    center = platform.center_of_mass + np.array([-0.02, 0.05, 0.03])
    inertia = 1.5 * platform.inertia + np.diag([0.1, 0.2, 0.3])
    load = replace(
        platform, mass=1.3 * platform.mass, center_of_mass=frozen_array(center), inertia=frozen_array(inertia)
    )
    return replace(robot, platform=load)


@lru_cache
def braced() -> Robot:
    """Return the same platform on eight cables that restrain it well in all directions, as controllers require."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    flips = [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [-1, 1, 1], [1, 1, -1], [-1, 1, -1], [-1, 1, -1], [-1, 1, 1]]
    anchors = np.hstack([2.0 * corners + [0.0, 0.0, 2.0], corners * flips * [0.3, 0.3, 0.25]])
    platform = free().platform
    x, y, z = platform.center_of_mass
    return make_robot(anchors, inertia=platform.inertia, center_of_mass=(float(x), float(y), float(z)))


@lru_cache
def planar() -> Robot:
    """Return a robot with four cables in a vertical plane: dof x, z and ry; centre of mass off the y axis."""
    frame = np.array([[-2, 0, 0], [2, 0, 0], [-2, 0, 4], [2, 0, 4]], dtype=float)
    box = np.array([[0.3, 0, -0.2], [-0.3, 0, -0.25], [-0.3, 0, 0.2], [0.3, 0, 0.15]])
    inertia = np.array([[2.0, 0.2, -0.1], [0.2, 3.0, 0.3], [-0.1, 0.3, 4.0]])
    return make_robot(
        np.hstack([frame, box]), inertia=inertia, center_of_mass=(0.08, 0.03, -0.05), dof=("x", "z", "ry")
    )


@lru_cache
def spherical() -> Robot:
    """Return the free robot's platform on a ball joint at its origin, with its centre of mass off the origin."""
    return replace(free(), dof=("rx", "ry", "rz"))


@lru_cache
def ball() -> Robot:
    """Return a robot with equal inertia about all axes and centre of mass at the origin: velocities stay constant."""
    return make_robot(crossed(6), mass=2.0, inertia=0.1 * np.eye(3))


@lru_cache
def solver_robots() -> tuple[Robot, ...]:
    """Return robots of all redundancies: spatial with 6 to 12 cables, planar, point masses, a carriage."""
    point = crossed(4)
    point[:, 3:] = 0.0
    rail = np.array([[-2.0, 0, 0, -0.1, 0, 0], [2.0, 0, 0, 0.1, 0, 0]])
    return (
        *(make_robot(crossed(m)) for m in (6, 7, 8, 12)),
        planar(),
        make_robot(point, dof=("x", "y", "z")),
        make_robot(point[:3], dof=("x", "y", "z")),
        make_robot(rail, dof=("x",)),
    )


@lru_cache
def sparse() -> Robot:
    """Return a robot with fewer cables than degrees of freedom."""
    return make_robot(crossed(8)[[1, 3, 5, 7]])


def attitude(rng: np.random.Generator) -> Array:
    """Return a uniformly distributed unit quaternion (4,) with w >= 0."""
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    return np.asarray(q if q[0] >= 0.0 else -q)


def state(rng: np.random.Generator, *, speed: float = 1.0, tilt: float | None = None) -> Array:
    """Return a state (13,) near the cube's centre, in any attitude or tilted by up to `tilt` rad about each axis."""
    q = attitude(rng) if tilt is None else rotations.from_rpy(*rng.uniform(-tilt, tilt, 3))
    position = np.array([0.0, 0.0, 2.0]) + rng.uniform(-0.4, 0.4, 3)
    return np.concatenate([position, q, speed * rng.normal(size=6)])


def planar_state(rng: np.random.Generator, *, speed: float = 1.0) -> Array:
    """Return a valid state (13,) of the planar robot."""
    vx, vz, spin = speed * rng.normal(size=3)
    q = rotations.from_axis_angle(np.array([0.0, 1.0, 0.0]), rng.uniform(-0.6, 0.6))
    x, z = rng.uniform(-0.4, 0.4, 2)
    return np.concatenate([[x, 0.0, 2.0 + z], q, [vx, 0.0, vz], [0.0, spin, 0.0]])


def spherical_state(rng: np.random.Generator, *, speed: float = 1.0) -> Array:
    """Return a valid state (13,) of the spherical robot: any attitude about a ball near the centre of the cube."""
    given = state(rng, speed=speed)
    given[7:10] = 0.0
    return given


def acceleration(robot: Robot, state: Array, gravity: Array, command: Array, external: Array) -> Array:
    """Return linear and angular acceleration of the origin (6,), world axes; held directions stay at rest.

    The inverse dynamics are linear in the acceleration, and the guide provides the constraint wrench: the rows and
    columns of the degrees of freedom alone give the equations of motion.
    """
    rows = robot.rows
    bias = dynamics.required_wrench(robot, state, gravity)
    columns = [dynamics.required_wrench(robot, state, gravity, e[:3], e[3:]) - bias for e in np.eye(6)[rows]]
    mass = np.array(columns).T[rows]
    load = kinematics.wrench_matrix(robot, state) @ command + external - bias
    result = np.zeros(6)
    result[rows] = np.linalg.solve(mass, load[rows])
    return result


def travel(
    robot: Robot, start: Array, gravity: Array, command: Array, external: Array, seconds: float, step: float
) -> Array:
    """Return the state (13,) after a time under constant commands and wrench, by the classical Runge-Kutta scheme."""

    def slope(y: Array) -> Array:
        spin = 0.5 * rotations.multiply(np.concatenate([[0.0], y[10:]]), y[3:7])
        return np.concatenate([y[7:10], spin, acceleration(robot, y, gravity, command, external)])

    y = np.array(start)
    for _ in range(round(seconds / step)):
        a = slope(y)
        b = slope(y + 0.5 * step * a)
        c = slope(y + 0.5 * step * b)
        d = slope(y + step * c)
        y = y + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        y[3:7] /= np.linalg.norm(y[3:7])
    return y


def distance(a: Array, b: Array) -> float:
    """Return the largest difference of two states (13,) in position, rotation vector and twist."""
    turn = rotations.rotation_vector(rotations.multiply(a[3:7], rotations.conjugate(b[3:7])))
    return float(np.max(np.abs(np.concatenate([a[:3] - b[:3], turn, a[7:] - b[7:]]))))


@dataclass(frozen=True, eq=False)
class Problem:
    """Problem W t = wrench, t_min <= t <= t_max, with W (n, m)."""

    robot: Robot
    W: Array
    wrench: Array
    t_min: Array
    t_max: Array

    def with_wrench(self, wrench: Array) -> Problem:
        """Return the problem with another wrench (n,)."""
        return replace(self, wrench=np.ascontiguousarray(wrench))


def problem(robot: Robot, state: Array, tension: Array) -> Problem:
    """Return the problem at a state (13,) with the wrench that `tension` (m,) balances."""
    W = np.ascontiguousarray(kinematics.wrench_matrix(robot, state)[robot.rows])
    return Problem(robot, W, W @ tension, robot.tension_min.copy(), robot.tension_max.copy())


def robot_state(robot: Robot, rng: np.random.Generator) -> Array:
    """Return a valid state (13,) of a robot of `solver_robots`."""
    if robot.n == 6:
        return state(rng, tilt=0.3)
    if "ry" in robot.dof:
        return planar_state(rng)
    position = rng.uniform(-0.5, 0.5, 3) * [name in robot.dof for name in "xyz"]
    return kinematics.make_state(position + ([0.0, 0.0, 2.0] if robot.n == 3 else [0.0, 0.0, 0.0]))


@lru_cache
def feasible(count: int = 200) -> tuple[tuple[Problem, ...], ...]:
    """Return problems with a known answer for each robot."""
    groups = []
    for k, robot in enumerate(solver_robots()):
        rng = np.random.default_rng(100 + k)
        low, high = robot.tension_min, robot.tension_max
        reach = rng.uniform(0.05, 1.0, (count, 1))  # many loads that are small compared with the limits
        tensions = low + (high - low) * reach * rng.uniform(0.0, 1.0, (count, robot.m))
        groups.append(tuple(problem(robot, robot_state(robot, rng), tension) for tension in tensions))
    return tuple(groups)


@lru_cache
def paths(count: int = 3) -> tuple[tuple[Path, ...], ...]:
    """Return smooth, feasible paths of pose and wrench for each robot."""
    groups = []
    for k, robot in enumerate(solver_robots()):
        group = []
        for number in range(count):
            rng = np.random.default_rng(70 + 10 * k + number)
            poses = np.array([robot_state(robot, rng)[:7] for _ in range(2)])
            tensions = np.array([robot.tension_min + rng.uniform(0.0, 400.0, robot.m) for _ in range(2)])
            group.append(Path(robot, poses, tensions))
        groups.append(tuple(group))
    return tuple(groups)


@lru_cache(maxsize=8192)  # some 2400 are shared by all solvers
def on_path(path: Path, s: float) -> Problem:
    """Return the problem at 0 <= s <= 1."""
    return Problem(path.robot, *path.at(s), path.robot.tension_min, path.robot.tension_max)


@lru_cache
def misleading(count: int, seed: int) -> tuple[tuple[adversaries.Adversaries, tuple[Problem, ...]], ...]:
    """Return adversarial problems of each robot of `cdpr.analysis.bench.adversaries`, together and singly."""
    groups = []
    for robot in adversaries.robots():
        found = adversaries.adversaries(robot, count, seed)
        rows = zip(found.W, found.wrench, found.low, found.high, strict=True)
        groups.append((found, tuple(Problem(robot, *row) for row in rows)))
    return tuple(groups)


@lru_cache
def infeasible() -> tuple[tuple[Problem, ...], ...]:
    """Return infeasible problems for each robot: along some direction, the wrench exceeds the reach of the cables.

    For any y, y . W t is at most the sum of the larger of c_i t_min,i and c_i t_max,i with c = W^T y (Farkas).
    """
    groups = []
    for k, group in enumerate(feasible()):
        rng = np.random.default_rng(200 + k)
        impossible = []
        for possible in group:
            y = rng.normal(size=possible.robot.n)
            c = possible.W.T @ y
            most = float(np.maximum(c * possible.t_min, c * possible.t_max).sum())
            lacking = most - y @ possible.wrench + max(1.0, 0.05 * abs(most))
            impossible.append(possible.with_wrench(possible.wrench + y * (lacking / (y @ y))))
        groups.append(tuple(impossible))
    return tuple(groups)
