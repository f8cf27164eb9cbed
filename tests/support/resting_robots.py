"""Random robots of all kinds with given lengths and tensions, and their energy by numpy."""

from __future__ import annotations

import numpy as np

import cdpr
from cdpr.cables.pulley import Pulley
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.model import rotations

DOFS = (
    ("x", "y", "z"),
    ("x", "z"),
    ("x", "z", "ry"),
    ("x", "y", "z", "rx", "ry", "rz"),
    ("x", "y", "z", "rz"),
    ("rx", "ry", "rz"),
    ("z",),
    ("y", "z", "rx"),
)
G = 9.81


def random_robot(rng):
    """A robot of 1 to 12 cables, 0.3 to 30 m in size and 0.1 to 1000 kg: elastic, inextensible or both."""
    m, dof, size = int(rng.integers(1, 13)), DOFS[rng.integers(len(DOFS))], 10.0 ** rng.uniform(-0.5, 1.5)
    frame, platform = rng.uniform(-1.0, 1.0, (m, 3)) * size, rng.uniform(-0.15, 0.15, (m, 3)) * size
    suspended = rng.random() < 0.5
    frame[:, 2] = size * (rng.uniform(0.9, 1.1, m) if suspended else rng.choice([-1.0, 1.0], m))
    if not any(name.startswith("r") for name in dof) and rng.random() < 0.5:
        platform[:] = 0.0
    mass, kind = 10.0 ** rng.uniform(-1.0, 3.0), rng.integers(3)
    cables = []
    for a, b in zip(frame, platform, strict=True):
        stretches = kind == 0 or (kind == 2 and rng.random() < 0.5)
        pulley = Pulley(radius=0.02 * size) if rng.random() < 0.2 else None
        axial = G * mass * 10.0 ** rng.uniform(0.5, 4.5)
        winch = cdpr.model.Winch(drum_radius=0.05, inertia=0.01)
        model = "elastic" if stretches else "ideal"
        cables.append(cdpr.Cable(a, b, 0.0, 1e6, model=model, axial_stiffness=axial, exit=pulley, winch=winch))
    center = rng.uniform(-0.1, 0.1, 3) * size if rng.random() < 0.5 else np.zeros(3)
    body = cdpr.Platform(mass, np.eye(3) * mass * (0.1 * size) ** 2, center)
    return cdpr.Robot(body, cables, dof, home=[0.0, 0.0, 0.0]), size


def random_case(seed):
    """A random robot, its unwound lengths (m,) and tensions (m,), NaN for the other kind, and a start (7,)."""
    rng = np.random.default_rng(seed)
    robot, size = random_robot(rng)
    pose = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    slides, turns = [row for row in robot.rows if row < 3], [row - 3 for row in robot.rows if row >= 3]
    pose[slides] = rng.uniform(-0.4, 0.4, 3)[slides] * size
    if len(turns) == 3:
        q = rng.normal(size=4)
        q[0] = 2.0 + abs(q[0])
        pose[3:] = q / np.linalg.norm(q)
    elif turns:
        pose[3:] = rotations.from_axis_angle(np.eye(3)[turns[0]], rng.uniform(-0.5, 0.5))
    exact = rng.random() < 0.3
    unwound = lengths(robot, make_state(pose[:3], pose[3:])) * (1.0 if exact else rng.uniform(0.97, 1.15, robot.m))
    tension = np.full(robot.m, np.nan)
    if rng.random() < 0.3:
        held = rng.random(robot.m) < 0.3
        held[0] = False
        tension[held] = G * robot.platform.mass * rng.uniform(0.0, 0.5, held.sum())
        unwound[held] = np.nan
    return robot, unwound, tension, np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


def path_lengths(robot, pose):
    """Lengths (m,) of the cables; pulleys as in Pott (2018), section 3.4."""
    R, found = rotations.matrix(pose[3:]), []
    for cable in robot.cables:
        d = pose[:3] + R @ cable.platform - cable.frame
        radius = getattr(cable.exit, "radius", 0.0)
        if radius == 0.0:
            found.append(np.linalg.norm(d))
            continue
        x, z = np.hypot(d[0], d[1]), d[2]
        tangent = np.sqrt(max((x - radius) ** 2 + z * z - radius * radius, 0.0))
        angle = np.arctan2(tangent * (x - radius) + radius * z, tangent * z - radius * (x - radius))
        found.append(radius * (angle if angle >= -np.pi / 2 else angle + 2.0 * np.pi) + tangent)
    return np.array(found)


def energy_of(robot, unwound, tension, pose):
    """Energy [J] of weight, springs (where `unwound` is not NaN) and constant tensions."""
    length, axial = path_lengths(robot, pose), np.array([cable.axial_stiffness for cable in robot.cables])
    center = pose[:3] + rotations.matrix(pose[3:]) @ robot.platform.center_of_mass
    stretch = np.maximum(length - np.nan_to_num(unwound), 0.0)
    springs = np.where(np.isnan(unwound), 0.0, 0.5 * axial * stretch**2 / np.where(np.isnan(unwound), 1.0, unwound))
    return float(G * robot.platform.mass * center[2] + springs.sum() + (np.nan_to_num(tension) * length).sum())
