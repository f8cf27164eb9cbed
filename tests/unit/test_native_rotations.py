"""Shared mathematics of the kernel library: the bits of the numba kernels, and those of one lane in eight."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from kernel_cases import COUNT, assert_same_bits, numbers, run, run_lanes

from cdpr.model import cholesky, kernels
from cdpr.model.jit import kernel
from cdpr.model.kernels import quaternion, store, vector
from cdpr.native.cholesky import solve_positive_definite
from cdpr.native.rotations import from_rotation_vector, multiply, rotate, rotation_vector

compiled = pytest.mark.skipif(
    numba.config.DISABLE_JIT, reason="interpreted kernels raise where compiled ones divide by 0"
)


@kernel
def each_row(q, p, v, rotated, product, logarithm, exponential):
    """Call the kernels for each row."""
    for i in range(q.shape[0]):
        store(kernels.rotate(quaternion(q[i], 0), vector(v[i], 0)), rotated[i], 0)
        turned = kernels.multiply(quaternion(q[i], 0), quaternion(p[i], 0))
        found = kernels.exponential(vector(v[i], 0))
        for j in range(4):
            product[i, j] = turned[j]
            exponential[i, j] = found[j]
        store(kernels.logarithm(quaternion(q[i], 0)), logarithm[i], 0)


def rows(rng):
    q, p, v = numbers(rng, COUNT, 4), numbers(rng, COUNT, 4), numbers(rng, COUNT, 3)
    q[::3] /= np.linalg.norm(q[::3], axis=1)[:, None]
    q[: COUNT // 10, 1:] *= 1e-9  # nearly no rotation
    v[: COUNT // 10] *= 1e-9
    return q, p, v


@compiled
def test_rotations_have_the_bits_of_numba_and_of_each_lane():
    q, p, v = rows(np.random.default_rng(1))
    expected = [np.empty((COUNT, width)) for width in (3, 4, 3, 4)]
    each_row(q, p, v, *expected)
    cases = [
        ("rotations", {"quaternion": q, "vector": v}, ("rotated", 3)),
        ("quaternion_products", {"left": q, "right": p}, ("product", 4)),
        ("rotation_vectors", {"quaternion": q}, ("vector", 3)),
        ("quaternions", {"vector": v}, ("quaternion", 4)),
    ]
    for (name, inputs, (out, width)), wanted in zip(cases, expected, strict=True):
        one = {key: value[None] for key, value in inputs.items()}  # all rows in one call
        found = run(name, one, {out: (COUNT, width)})[0][out]
        assert_same_bits(found[0], wanted)
        eights = {key: value.reshape(8, COUNT // 8, -1) for key, value in inputs.items()}
        lanes = run_lanes(name, eights, {out: (COUNT // 8, width)})[0][out]
        assert_same_bits(lanes.reshape(COUNT, width), wanted)


def systems(rng, n, count):
    """Positive definite, singular, indefinite and hostile matrices."""
    A, b = numbers(rng, count, n, n), numbers(rng, count, n)
    definite = np.arange(count) % 3 == 0
    A[definite] = A[definite] @ A[definite].swapaxes(1, 2)
    A[: count // 8, -1] = A[: count // 8, 0]  # singular, for n > 1
    return A, b


@compiled
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_cholesky_has_the_bits_of_numba_and_of_each_lane(damping):
    rng, solved = np.random.default_rng(2), 0
    for n in range(1, 7):
        A, b = systems(rng, n, 840)
        found, codes = run("positive_definite", {"matrix": A, "right": b}, {"solution": (n,)}, damping=damping)
        expected = np.full((len(A), n), np.nan)
        for k in range(len(A)):
            if cholesky.factorise(L := A[k].copy(), damping):
                cholesky.solve(L, b[k], expected[k])
                solved += codes[k] == 0
            else:
                assert codes[k] == 1
        assert_same_bits(found["solution"], expected)
        lanes, groups = run_lanes("positive_definite", {"matrix": A, "right": b}, {"solution": (n,)}, damping=damping)
        assert_same_bits(lanes["solution"], expected)
        assert [[group >> lane & 1 for lane in range(8)] for group in groups] == codes.reshape(-1, 8).tolist()
    assert 1500 < solved < 4500


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
