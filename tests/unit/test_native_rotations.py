"""Shared mathematics of the kernel library: against numpy, and the bits of one lane in eight."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import assert_same_bits, numbers, run, run_lanes

from cdpr.native.cholesky import solve_positive_definite
from cdpr.native.rotations import from_rotation_vector, multiply, rotate, rotation_vector

COUNT = 960


def rows(rng):
    q, p, v = numbers(rng, COUNT, 4), numbers(rng, COUNT, 4), numbers(rng, COUNT, 3)
    q[::3] /= np.linalg.norm(q[::3], axis=1)[:, None]
    q[: COUNT // 10, 1:] *= 1e-9  # nearly no rotation
    v[: COUNT // 10] *= 1e-9
    return q, p, v


def test_rotations_have_the_bits_of_each_lane():
    q, p, v = rows(np.random.default_rng(1))
    cases = [
        ("rotations", {"quaternion": q, "vector": v}, ("rotated", 3)),
        ("quaternion_products", {"left": q, "right": p}, ("product", 4)),
        ("rotation_vectors", {"quaternion": q}, ("vector", 3)),
        ("quaternions", {"vector": v}, ("quaternion", 4)),
    ]
    for name, inputs, (out, width) in cases:
        one = {key: value[None] for key, value in inputs.items()}  # all rows in one call
        found = run(name, one, {out: (COUNT, width)})[0][out]
        eights = {key: value.reshape(8, COUNT // 8, -1) for key, value in inputs.items()}
        lanes = run_lanes(name, eights, {out: (COUNT // 8, width)})[0][out]
        assert_same_bits(lanes.reshape(COUNT, width), found[0])


def systems(rng, n, count):
    """Positive definite, singular, indefinite and hostile matrices."""
    A, b = numbers(rng, count, n, n), numbers(rng, count, n)
    definite = np.arange(count) % 3 == 0
    A[definite] = A[definite] @ A[definite].swapaxes(1, 2)
    A[: count // 8, -1] = A[: count // 8, 0]  # singular, for n > 1
    return A, b


@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_cholesky_solves_and_has_the_bits_of_each_lane(damping):
    rng, solved = np.random.default_rng(2), 0
    for n in range(1, 7):
        A, b = systems(rng, n, 48)
        found, codes = run("positive_definite", {"matrix": A, "right": b}, {"solution": (n,)}, damping=damping)
        for k in np.flatnonzero((codes == 0) & (np.arange(48) % 3 == 0)):
            lower = np.tril(A[k])
            whole = lower + lower.T - np.diag(np.diag(lower)) + np.diag(damping * np.diag(lower))
            if np.isfinite(whole).all() and np.linalg.cond(whole) < 1e6:
                np.testing.assert_allclose(whole @ found["solution"][k], b[k], rtol=1e-6, atol=1e-6)
                solved += 1
        lanes, groups = run_lanes("positive_definite", {"matrix": A, "right": b}, {"solution": (n,)}, damping=damping)
        assert_same_bits(lanes["solution"], found["solution"])
        assert [[group >> lane & 1 for lane in range(8)] for group in groups] == codes.reshape(-1, 8).tolist()
    assert solved > 50


def test_functions_compute_what_they_say():
    rng = np.random.default_rng(3)
    q, p = rng.normal(size=(2, 4))
    q, p, v = q / np.linalg.norm(q), p / np.linalg.norm(p), rng.normal(size=3)
    np.testing.assert_allclose(rotate(multiply(q, p), v), rotate(q, rotate(p, v)), atol=1e-14)
    np.testing.assert_allclose(from_rotation_vector(rotation_vector(q)) * np.sign(q[0]), q, atol=1e-14)
    np.testing.assert_allclose(
        rotate(from_rotation_vector([0.0, 0.0, np.pi / 2]), [1.0, 0.0, 0.0]), [0, 1, 0], atol=1e-15
    )
    assert rotate(np.tile(q, (5, 1)), np.tile(v, (5, 1))).shape == (5, 3)
    A = rng.normal(size=(4, 4))
    A = A @ A.T
    np.testing.assert_allclose(A @ solve_positive_definite(A, v4 := rng.normal(size=4)), v4, atol=1e-10)
    assert np.isnan(solve_positive_definite(np.zeros((2, 2)), [1.0, 1.0])).all()
    with pytest.raises(ValueError, match=r"rotations: vector: expected shape \(k, 3\)"):
        rotate([1.0, 0.0, 0.0, 0.0], [1.0, 0.0])
    with pytest.raises(ValueError, match=r"rotations: vector: expected shape \(k, 3\)"):
        rotate(np.zeros((2, 4)), np.zeros((3, 3)))
