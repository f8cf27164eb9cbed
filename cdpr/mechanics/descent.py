"""Minima and other stationary points of the potential energy of a platform.

Both methods use the exact Hessian, on positions and rotations (Absil, Mahony and Sepulchre, Optimization Algorithms on
Matrix Manifolds, 2008, chapter 7). Cables that become slack or taut only make the Hessian jump.
"""

from __future__ import annotations

import math

import numpy as np

from cdpr.mechanics.potential import Potential
from cdpr.model.robot import Array

MOST_STEPS = 3000  # of a descent; stiff cables that become taut and slack in turn need many
MOST_SEARCHED = 100  # of a search for a stationary point
FIRST_RADIUS, LARGEST_RADIUS, LEAST_RADIUS = 0.05, 0.5, 1e-15  # of steps, as shares of the size
FAR = 100.0  # distance from the start, as a multiple of the size, from which a platform is falling
ROUND_OFF = 1e-12  # error of an energy, as a share of its parts
FLAT = 1e-9  # smaller curvatures, as shares of the largest one and of load / size, are round-off
SUFFICIENT = 1e-4  # least share of the predicted decrease


def flat(values: Array, potential: Potential) -> float:
    """Return the curvature [N/m] below which eigenvalues of a Hessian are round-off."""
    return 1e-10 * float(np.abs(values).max(initial=0.0)) + FLAT * potential.load() / potential.size


def descend(potential: Potential, start: Array, tolerance: float) -> tuple[Array, bool]:
    """Return a local minimum (7,) by a trust-region Newton method, and whether it converged.

    It converges if the norm of the scaled gradient is at most `tolerance` times the load and the Hessian has no
    negative curvature.

    Args:
        potential: energy.
        start: (7,) initial pose.
        tolerance: share of the load.
    """
    pose, size = start, potential.size
    radius = FIRST_RADIUS * size
    energy, gradient, hessian = potential.evaluate(pose)
    for _ in range(MOST_STEPS):
        if not (math.isfinite(energy) and np.isfinite(hessian).all()):
            return pose, False
        values, vectors = np.linalg.eigh(hessian)
        norm, load = math.sqrt(gradient @ gradient), potential.load()
        curved = values[0] < -flat(values, potential)
        if norm <= tolerance * load and not curved:
            return pose, True
        if math.dist(pose[:3], start[:3]) > FAR * size:
            return pose, False
        step = vectors @ trust_step(values, vectors.T @ gradient, radius, curved)
        predicted = -float(gradient @ step + 0.5 * step @ hessian @ step)
        trial = potential.moved(pose, step)
        then, slope, curvature = potential.evaluate(trial)
        length, gain = math.sqrt(step @ step), energy - then
        if abs(predicted) <= ROUND_OFF * (abs(energy) + load * size):
            good, ratio = math.sqrt(slope @ slope) < norm or (curved and gain >= 0.0), 1.0
        else:
            ratio = gain / predicted
            good = ratio > SUFFICIENT
        if good:
            pose, energy, gradient, hessian = trial, then, slope, curvature
        if good and ratio > 0.75 and length > 0.8 * radius:
            radius = min(2.0 * radius, LARGEST_RADIUS * size)
        elif not good or ratio < 0.25:
            radius = 0.25 * length
        if radius < LEAST_RADIUS * size:
            break
        if not good:
            potential.evaluate(pose)
    potential.evaluate(pose)
    return pose, False


def trust_step(values: Array, along: Array, radius: float, curved: bool) -> Array:
    """Return the minimum of a quadratic model within a ball, in the eigenvectors of its Hessian.

    Moré and Sorensen, Computing a trust region step, SIAM J. Sci. Stat. Comput. 4, 1983.

    Args:
        values: (n,) eigenvalues, ascending.
        along: (n,) gradient.
        radius: radius of the ball.
        curved: True if the first eigenvalue is negative beyond round-off.
    """
    if values[0] > 0.0:
        step = -along / values
        if step @ step <= radius * radius:
            return step
    norm = math.sqrt(along @ along)
    least = max(1e-14 * float(np.abs(values).max()), 1e-9 * norm / radius, 1e-300)
    low = max(0.0, -float(values[0])) + least
    high = max(low, norm / radius - float(values[0]))
    damping = max(low, 1e-3 * high)
    step = -along / (values + low)
    size = math.sqrt(step @ step)
    if size <= radius:  # no gradient along the most curved direction, or a flat one
        if curved:
            step[0] += math.copysign(math.sqrt(radius * radius - size * size), -along[0] or 1.0)
        return step
    for _ in range(50):
        step = -along / (values + damping)
        size = math.sqrt(step @ step)
        if abs(size - radius) <= 0.05 * radius:
            break
        low, high = (damping, high) if size > radius else (low, damping)
        steepness = float((step * step / (values + damping)).sum())
        damping += size * size / steepness * (size - radius) / radius
        if not low < damping < high:
            damping = math.sqrt(low * high) if low > 0.0 else 0.5 * high
    return step


def seek(potential: Potential, start: Array, tolerance: float) -> tuple[Array, bool]:
    """Return a stationary point (7,) of any kind near the start, and whether it converged.

    It minimises the norm of the gradient by damped Newton steps (Marquardt, 1963).
    """
    pose, size = start, potential.size
    _, gradient, hessian = potential.evaluate(pose)
    damping, tried = -1.0, True
    for _ in range(MOST_SEARCHED):
        if not np.isfinite(hessian).all():
            break
        norm = math.sqrt(gradient @ gradient)
        if norm <= tolerance * potential.load():
            return pose, True
        if tried:
            values, vectors = np.linalg.eigh(hessian)
            along = vectors.T @ gradient
            if damping < 0.0:
                damping = 1e-3 * float(np.abs(values).max()) ** 2
        step = vectors @ (-values * along / np.maximum(values * values + damping, 1e-300))
        length = math.sqrt(step @ step)
        if length > 0.1 * size:
            step *= 0.1 * size / length
        trial = potential.moved(pose, step)
        _, slope, curvature = potential.evaluate(trial)
        tried = bool(math.sqrt(slope @ slope) < norm)
        if tried:
            pose, gradient, hessian, damping = trial, slope, curvature, 0.1 * damping
        else:
            damping = max(4.0 * damping, 1e-16 * float(np.abs(values).max()) ** 2)
            potential.evaluate(pose)
            if length < 1e-14 * size:
                break
    return pose, False
