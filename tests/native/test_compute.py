"""Calls of compiled operations with changing arrays."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cdpr.native import compute as module
from cdpr.native.bind import bind
from cdpr.native.compute import compute


def cross(left, right):
    status, (product,) = compute("cross_products", {"left": left, "right": right}, {"product": (len(left), 3)})
    assert status == 0
    return product


def test_results_are_arrays_of_their_own_and_inputs_of_any_kind():
    left, right = np.random.default_rng(1).normal(size=(2, 4, 3))
    first = cross(left, right)
    np.testing.assert_allclose(first, np.cross(left, right), rtol=1e-15)
    kept = first.copy()
    np.testing.assert_array_equal(cross(left[::-1], right[:, ::-1]), np.cross(left[::-1], right[:, ::-1]))
    np.testing.assert_array_equal(first, kept)
    assert cross([[1, 0, 0]], [[0, 1, 0]]).tolist() == [[0.0, 0.0, 1.0]]
    assert cross(np.array([[1, 0, 0]]), np.array([[0, 1, 0]])).tolist() == [[0.0, 0.0, 1.0]]


def test_numbers_that_are_equal_in_python_alone_are_distinguished():
    given, outputs = {"matrix": [[1.0]], "right": [1.0]}, {"solution": (1,)}
    module._kept.bound.clear()
    for damping in (0.0, -0.0, 0.0):
        compute("positive_definite", given, outputs, damping=damping)
    assert len({call.words for call, *_ in module._kept.bound.values()}) == 2
    box = {"basis": [[1.0]], "box": [[0.0], [-1.0], [1.0]]}, {"x": (1,), "distance": (1,)}
    compute("safest_point", *box, ball=1)
    with pytest.raises(TypeError, match="ball: expected an integer, got float"):
        compute("safest_point", *box, ball=1.0)


def test_arrays_that_are_read_and_written_and_integers():
    status, (external,) = compute("external_loads", {"loads": np.zeros((0, 10)), "sample": [3]}, {"external": (6,)})
    assert (status, external.tolist()) == (0, [0.0] * 6)
    row = np.arange(3.0)
    for _ in range(2):
        assert compute("stamp", {"row": row}, {"row": (3,)})[1][0].tolist() == [0.0, 1.0, 2.0]
    assert row.tolist() == [0.0, 1.0, 2.0]


def test_each_thread_has_arrays_of_its_own():
    rng = np.random.default_rng(2)
    cases = rng.normal(size=(400, 2, 5, 3))
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda case: cross(*case), cases))
    np.testing.assert_allclose(found, np.cross(cases[:, 0], cases[:, 1]), rtol=1e-12, atol=1e-14)


def test_an_operation_is_bound_once_for_each_set_of_shapes(monkeypatch):
    made = []
    monkeypatch.setattr(module, "bind", lambda name, **given: made.append(name) or bind(name, **given))
    module._kept.bound.clear()
    for count in [1, 2] * 5:
        cross(np.ones((count, 3)), np.ones((count, 3)))
    assert len(made) == 2
    for count in range(3 * module.MOST):
        cross(np.ones((count, 3)), np.ones((count, 3)))
    assert len(module._kept.bound) <= module.MOST


def test_mismatches_give_one_clear_error():
    with pytest.raises(ValueError, match=r"cross_products: right: expected shape \(n, 3\) with n = 2 from 'left'"):
        cross(np.ones((2, 3)), np.ones((3, 3)))
    with pytest.raises(TypeError, match=r"cross_products: missing arguments right"):
        compute("cross_products", {"left": np.ones((2, 3))}, {"product": (2, 3)})
    with pytest.raises(ValueError, match=r"Unknown operation 'nothing'"):
        compute("nothing", {}, {})
