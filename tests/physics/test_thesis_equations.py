"""Right forms of equations that the thesis misprints; docs/thesis.md lists them."""

from __future__ import annotations

import numpy as np

from cdpr.mechanics.kinematics import lengths, make_state, rates, wrench_matrix
from cdpr.model.rotations import matrix, multiply

STEP = 1e-5  # m, rad, s
DIFFERENCES = (
    1e-8  # of central differences with that step: round-off over it, and its square, relative to the largest entry
)

POSE = make_state([0.2, -0.1, 1.3], [0.96, 0.16, -0.16, 0.16 * 0.98], [0.3, -0.2, 0.5], [0.4, 0.7, -0.6])
POSE[3:7] /= np.linalg.norm(POSE[3:7])


def moved(state, j, step):
    """The state with its pose moved along, or turned about, world axis j (of 6)."""
    state = state.copy()
    if j < 3:
        state[j] += step
    else:
        turn = np.zeros(3)
        turn[j - 3] = np.sin(0.5 * step)
        state[3:7] = multiply(np.array([np.cos(0.5 * step), *turn]), state[3:7])
    return state


def by_pose(of):
    """Derivatives of an array by the pose, last index (6,)."""
    return np.stack([(of(moved(POSE, j, STEP)) - of(moved(POSE, j, -STEP))) / (2.0 * STEP) for j in range(6)], axis=-1)


def test_the_stiffness_of_elastic_cables(offset_robot):
    """2.25 and 2.26: K = -d(W t)/dx = W k W^T - (dW/dx) t for tensions k (l - l0); it drives the platform back."""
    rng = np.random.default_rng(0)
    k = rng.uniform(2e4, 5e4, offset_robot.m)  # N/m
    unstretched = lengths(offset_robot, POSE) * rng.uniform(0.98, 0.999, offset_robot.m)

    def tensions(state):
        return k * (lengths(offset_robot, state) - unstretched)

    W, t = wrench_matrix(offset_robot, POSE), tensions(POSE)
    K = -by_pose(lambda state: wrench_matrix(offset_robot, state) @ tensions(state))
    turning = np.einsum("nmj,m->nj", by_pose(lambda state: wrench_matrix(offset_robot, state)), t)
    assert np.abs(W * k @ W.T - turning - K).max() < DIFFERENCES * np.abs(K).max()
    assert np.abs(turning).max() > 1e-3 * np.abs(K).max()  # a wrong sign of it would be seen
    assert np.linalg.eigvalsh(K + K.T).min() > 0.0


def test_the_moment_of_a_cable(offset_robot):
    """5.5: with the lever first, cables and their wrench have the same power; the other way round they have not."""
    W, t = wrench_matrix(offset_robot, POSE), np.linspace(100.0, 300.0, offset_robot.m)
    power = -t @ rates(offset_robot, POSE)
    assert abs((W @ t) @ POSE[7:] - power) < 1e-12 * abs(t) @ abs(rates(offset_robot, POSE))
    arms = offset_robot.anchors[:, 3:] @ matrix(POSE[3:7]).T
    np.testing.assert_allclose(W[3:], np.cross(arms, W[:3].T).T, atol=1e-15)
    swapped = np.vstack([W[:3], -W[3:]])
    assert abs((swapped @ t) @ POSE[7:] - power) > 1.0
    ahead, behind = (lengths(offset_robot, moved_by_twist(side * STEP)) for side in (1.0, -1.0))
    assert abs(power + t @ (ahead - behind) / (2.0 * STEP)) < DIFFERENCES * abs(t).sum()


def moved_by_twist(step):
    """The state a time later, s, by its twist."""
    state = POSE.copy()
    for j in range(6):
        state = moved(state, j, step * POSE[7 + j])
    return state
