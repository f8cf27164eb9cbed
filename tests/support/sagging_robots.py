"""Random robots on heavy cables, and the forces of their cables by Irvine's equations with scipy."""

from __future__ import annotations

import numpy as np
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.cables.pulley import Pulley

G = 9.81
DOFS = (("x", "y", "z"), ("x", "z"), ("x", "y", "z", "rx", "ry", "rz"), ("x", "z", "ry"), ("z",))


def random_sagging(seed, pulleys=False):
    """A robot on 2 to 9 catenaries, its unwound lengths (m,), and a start (7,)."""
    rng = np.random.default_rng(seed)
    m, dof, size = int(rng.integers(2, 10)), DOFS[rng.integers(len(DOFS))], 10.0 ** rng.uniform(0.0, 1.3)
    frame, platform = rng.uniform(-1.0, 1.0, (m, 3)) * size, rng.uniform(-0.15, 0.15, (m, 3)) * size
    frame[:, 2] = size * rng.uniform(0.9, 1.1, m)
    mass = 10.0 ** rng.uniform(0.5, 2.5)
    axial = G * mass * 10.0 ** rng.uniform(1.0, 4.0)
    density = mass / (m * size) * 10.0 ** rng.uniform(-3.0, -0.3)
    exit = Pulley(radius=0.02 * size) if pulleys else None
    given = {"model": "catenary", "axial_stiffness": axial, "linear_density": density, "exit": exit}
    winch = cdpr.model.Winch(drum_radius=0.05, inertia=0.01)
    cables = [cdpr.Cable(a, b, 1.0, 1e6, winch=winch, **given) for a, b in zip(frame, platform, strict=True)]
    robot = cdpr.Robot(cdpr.Platform(mass, np.eye(3) * mass * (0.1 * size) ** 2), cables, dof, home=[0.0, 0.0, 0.0])
    start = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    length = cdpr.mechanics.kinematics.lengths(robot, cdpr.mechanics.kinematics.make_state(start[:3], start[3:]))
    return robot, length * rng.uniform(0.99, 1.2, m), start


def irvine(H, V0, L, w, EA):
    """Distances of the ends, across and up, of a cable with unstretched length L; Irvine (1981), section 1.4."""
    V1 = V0 + w * L
    across = H * L / EA + H / w * (np.arcsinh(V1 / H) - np.arcsinh(V0 / H))
    return across, 0.5 * (V0 + V1) * L / EA + (np.hypot(H, V1) - np.hypot(H, V0)) / w


def end_force(chord, L, w, EA):
    """Force (3,) on the platform of a cable between two points."""
    level, z = float(np.hypot(chord[0], chord[1])), float(chord[2])
    size = np.hypot(level, z)
    taut = max(EA * (size / L - 1.0), 0.5 * w * L * level / size, 1e-3 * w * L)

    def miss(x):
        across, up = irvine(np.exp(x[0]), x[1], L, w, EA)
        return [(across - level) / size, (up - z) / size]

    best = None
    for factor in (1.0, 0.3, 3.0, 0.05, 0.01):
        first = [np.log(max(factor * taut * level / size, 1e-9)), factor * taut * z / size - 0.5 * w * L]
        x, _, _, _ = fsolve(miss, first, xtol=1e-14, full_output=True)
        error = float(np.hypot(*miss(x)))
        if best is None or error < best[0]:
            best = error, x
        if error < 1e-13:
            break
    H, V0 = np.exp(best[1][0]), best[1][1]
    return np.array([*(H * chord[:2] / level), V0])


def remaining(robot, pose, unwound):
    """Force and moment (6,) that remain on the platform at a pose, N and N m; exits are points."""
    R = Rotation.from_quat(pose[3:7], scalar_first=True).as_matrix()
    found = np.zeros(6)
    found[2] = -G * robot.platform.mass
    found[3:] = np.cross(R @ robot.platform.center_of_mass, found[:3])
    for cable, L in zip(robot.cables, unwound, strict=True):
        lever = R @ cable.platform
        f = end_force(cable.frame - pose[:3] - lever, L, cable.linear_density * G, cable.axial_stiffness)
        found += [*f, *np.cross(lever, f)]
    return found
