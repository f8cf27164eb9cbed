"""Random robots on heavy cables, and the forces of their cables by Irvine's equations with scipy."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.cables.pulley import Pulley

G = 9.81
SOLVED = 1e-12  # of the chord: what round-off leaves of Irvine's equations
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
    """Distances of the ends, across and up, of a cable with unstretched length L; Irvine (1981), section 1.4.

    Differences of nearly equal numbers, which a taut light cable has, are written as quotients.
    """
    V1 = V0 + w * L
    T0, T1 = math.hypot(H, V0), math.hypot(H, V1)
    if V0 * V1 > 0.0:
        angle = math.asinh(w * L * (V0 + V1) / (V0 * T1 + V1 * T0))
    else:
        angle = math.asinh(V1 / H) - math.asinh(V0 / H)
    return H * L / EA + H / w * angle, 0.5 * (V0 + V1) * L / EA + L * (V0 + V1) / (T0 + T1)


def bracketed(level, z, L, w, EA):
    """Horizontal force and lower vertical force, N; both distances grow with their own force, so brackets hold them."""
    most = 10.0 * (EA * math.hypot(level, z) / L + w * L)

    def lower(H):
        return brentq(lambda V0: irvine(H, V0, L, w, EA)[1] - z, -most, most, xtol=1e-300, rtol=1e-15)

    def beyond(logarithm):
        H = math.exp(logarithm)
        return irvine(H, lower(H), L, w, EA)[0] - level

    H = math.exp(brentq(beyond, math.log(1e-12 * w * L), math.log(most), xtol=1e-15, rtol=1e-15))
    return H, lower(H)


def end_force(chord, L, w, EA):
    """Force (3,) on the platform of a cable between two points."""
    level, z = float(np.hypot(chord[0], chord[1])), float(chord[2])
    H, V0 = bracketed(level, z, L, w, EA)
    across, up = irvine(H, V0, L, w, EA)
    assert np.hypot(across - level, up - z) < SOLVED * np.hypot(level, z)
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
