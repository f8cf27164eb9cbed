"""Attitudes against scipy, in and outside the kernels."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cdpr.model import rotations
from cdpr.native import rotations as compiled

pytestmark = pytest.mark.core

EXACT = 1e-14  # a few roundings

angles = st.floats(-3.0, 3.0)
vectors = st.tuples(angles, angles, angles).map(np.array)


def scipy_rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(q, scalar_first=True)


def same_rotation(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(min(np.abs(a - b).max(), np.abs(a + b).max()) < EXACT)


@given(vectors, st.sampled_from(["XYZ", "ZYX", "ZXZ", "xyz", "zyx", "xzx"]))
def test_euler_angles_as_scipy(v, order):
    assert same_rotation(rotations.from_euler(v, order), Rotation.from_euler(order, v).as_quat(scalar_first=True))


@given(vectors)
def test_thesis_matrix_and_rpy(v):
    """R = Rx Ry Rz is the thesis's (2.1); roll, pitch, yaw are about fixed axes."""
    x, y, z = (Rotation.from_rotvec(np.eye(3)[i] * v[i]).as_matrix() for i in range(3))
    np.testing.assert_allclose(rotations.matrix(rotations.from_euler(v, "XYZ")), x @ y @ z, atol=EXACT)
    np.testing.assert_allclose(rotations.matrix(rotations.from_rpy(*v)), z @ y @ x, atol=EXACT)


@given(vectors, vectors)
def test_products_and_matrices(a, b):
    p, q = rotations.from_rpy(*a), rotations.from_rpy(*b)
    product = rotations.multiply(p, q)
    np.testing.assert_allclose(rotations.matrix(product), rotations.matrix(p) @ rotations.matrix(q), atol=EXACT)
    np.testing.assert_allclose(compiled.multiply(p, q), product, atol=EXACT)
    np.testing.assert_allclose(compiled.rotate(p, b), rotations.matrix(p) @ b, atol=1e-13)
    assert same_rotation(rotations.from_matrix(rotations.matrix(p)), p)


@given(vectors, vectors)
def test_cross_products_are_those_of_numpy_to_the_bit(a, b):
    a, b = (np.array([v, [0.0, -0.0, 1.0], -v]) for v in (a, b))
    assert rotations.cross(a, b).tobytes() == np.cross(a, b).tobytes()


@given(vectors)
def test_rotation_vector_is_the_shorter_way(v):
    q = rotations.from_rpy(*v)
    expected = scipy_rotation(q).as_rotvec()
    for sign in (1.0, -1.0):
        for got in (rotations.rotation_vector(sign * q), compiled.rotation_vector(sign * q)):
            assert np.linalg.norm(got) <= np.pi + EXACT
            np.testing.assert_allclose(Rotation.from_rotvec(got).as_matrix(), rotations.matrix(q), atol=1e-13)
    if np.linalg.norm(expected) < 3.0:
        np.testing.assert_allclose(compiled.rotation_vector(q), expected, atol=1e-13)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-12, 1e-8, 1e-7, 1e-3, 3.14])
def test_exponential_and_logarithm_undo_each_other(size):
    v = size * np.array([0.6, -0.64, 0.48])
    q = compiled.from_rotation_vector(v)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(compiled.rotation_vector(q), v, rtol=1e-14, atol=1e-310)


FIXED = ["".join(axes) for axes in itertools.product("xyz", repeat=3) if axes[0] != axes[1] != axes[2]]
ORDERS = [*FIXED, *map(str.upper, FIXED)]


@pytest.mark.parametrize("order", ORDERS)
def test_euler_angles_there_and_back(order):
    rng = np.random.default_rng(3)
    aligned = [0.0, np.pi] if order[0] == order[2] else [0.5 * np.pi, -0.5 * np.pi]
    for middle in [*rng.uniform(-3, 3, 20), *aligned, *aligned]:
        q = rotations.from_euler(np.array([rng.uniform(-3, 3), middle, rng.uniform(-3, 3)]), order)
        back = rotations.from_euler(rotations.to_euler(q, order), order)
        assert same_rotation(back, q)


@pytest.mark.parametrize("order", ORDERS)
def test_euler_angles_are_those_of_scipy(order):
    q = np.random.default_rng(4).normal(size=4)
    q /= np.linalg.norm(q)
    np.testing.assert_allclose(rotations.to_euler(q, order), scipy_rotation(q).as_euler(order), atol=EXACT)


@given(vectors)
def test_of_the_two_quaternions_of_a_matrix_it_is_the_one_with_a_positive_first(v):
    assert rotations.from_matrix(Rotation.from_rotvec(3.0 * v).as_matrix())[0] >= 0.0


@pytest.mark.parametrize("shape", [(), (0,), (1,), (4,), (2, 3)])
def test_many_attitudes_are_as_one_to_the_bit(shape):
    """Shape (4, 4) must not be taken for a single quaternion."""
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, *shape, 4))
    vector = rng.normal(size=3)
    functions = {
        rotations.matrix: (3, 3),
        rotations.conjugate: (4,),
        rotations.rotation_vector: (3,),
        lambda q: rotations.rotate(q, vector): (3,),
        lambda q: rotations.between(a, q): (3,),
        lambda q: rotations.between(a[..., :1, :] if a.ndim > 1 else a, q): (3,),
    }
    for function, own in functions.items():
        assert function(b).shape == (*shape, *own)
    for at in np.ndindex(shape):
        assert rotations.between(a, b)[at].tobytes() == rotations.between(a[at], b[at]).tobytes()
        for function in list(functions)[:4]:
            assert function(b)[at].tobytes() == function(b[at]).tobytes()
        turned = rotations.multiply(b[at], rotations.conjugate(a[at]))
        np.testing.assert_allclose(rotations.between(a, b)[at], rotations.rotation_vector(turned), atol=1e-14)


@pytest.mark.parametrize("function", [rotations.multiply, rotations.to_euler])
@pytest.mark.parametrize("shape", [(0, 4), (1, 4), (4, 4)])
def test_functions_of_one_attitude_take_no_others(function, shape):
    arguments = {rotations.multiply: (np.ones(4),), rotations.to_euler: ("XYZ",)}.get(function, ())
    with pytest.raises((TypeError, ValueError, IndexError)):
        function(np.ones(shape), *arguments)
