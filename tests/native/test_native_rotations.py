"""Shared mathematics of the kernel library, against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import numbers, run

from cdpr.native.cholesky import solve_positive_definite
from cdpr.native.rotations import from_rotation_vector, multiply, rotate, rotation_vector


def systems(rng, n, count):
    """Positive definite, singular, indefinite and hostile matrices."""
    A, b = numbers(rng, count, n, n), numbers(rng, count, n)
    definite = np.arange(count) % 3 == 0
    A[definite] = A[definite] @ A[definite].swapaxes(1, 2)
    A[: count // 8, -1] = A[: count // 8, 0]  # singular, for n > 1
    return A, b


@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_cholesky_solves(damping):
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
    assert solved > 50


def test_functions_compute_their_documented_values():
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
