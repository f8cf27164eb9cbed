"""Numbers of eight lanes in numba kernels."""

from __future__ import annotations

import math
import operator

import numba
import numpy as np
import pytest

from cdpr.model import lanes
from cdpr.model.jit import kernel

WIDTH = lanes.WIDTH
ODD = (0.0, -0.0, 1.0, -3.5, math.inf, -math.inf, math.nan, 5e-324, 1e300, 1e-300)

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="only compiled code has lanes")


@kernel
def arithmetic(a, b, out):
    """One source of all that lanes can do."""
    s = 0.0
    for i in range(2):
        s += a[0] * b[0] - a[0] / b[0] + i
        s -= 0.5 * b[0]
    out[0] = s
    out[1] = math.sqrt(abs(a[0])) + -b[0]
    out[2], out[3], out[4] = max(a[0], b[0]), min(a[0], b[0]), max(1.0, a[0], b[0])
    less, same = (a[0] < b[0]) & (a[0] <= b[0]), (a[0] == b[0]) | (a[0] != a[0])
    out[5], out[6] = lanes.choose(less, a[0], 2.0), lanes.choose(same, 1, b[0])
    out[7] = lanes.choose((a[0] > b[0]) | (a[0] >= b[0]), 1.0, 0.0)


@kernel
def arithmetic_of_eight(a, b, out):
    arithmetic(lanes.side_by_side(a), lanes.side_by_side(b), lanes.side_by_side(out))


@kernel
def words(a, out):
    x = lanes.side_by_side(a)
    out[0], out[1] = lanes.some(x[0] > 2.0), lanes.every(x[0] > 2.0)
    out[2], out[3] = lanes.bits(x[0] > 2.0), lanes.whole(x[0])
    out[4] = lanes.bits(~(x[0] > 2.0))


def test_eight_numbers_are_what_each_is_alone():
    pairs = np.array([(a, b) for a in ODD for b in ODD])
    pairs = np.vstack([pairs, pairs[: -len(pairs) % WIDTH]])
    for eight in pairs.reshape(-1, WIDTH, 2):
        found = np.empty((8, WIDTH))
        arithmetic_of_eight(eight[:, :1].T.copy(), eight[:, 1:].T.copy(), found)
        for lane, (a, b) in enumerate(eight):
            out = np.empty(8)
            arithmetic(np.array([a]), np.array([b]), out)
            np.testing.assert_array_equal(found[:, lane], out, strict=True)
            finite = ~np.isnan(out)
            np.testing.assert_array_equal(np.signbit(found[finite, lane]), np.signbit(out[finite]))


@pytest.mark.parametrize("above", [0, 3, 8])
def test_words_ask_any_and_all_of_eight(above):
    out = np.empty(5)
    words(np.where(np.arange(WIDTH) < above, 3.0, 1.0)[None], out)
    rest = 2**WIDTH - 2**above
    assert out.tolist() == [above > 0, above == WIDTH, 2**above - 1, 3.0 if above else 1.0, rest]


def test_words_of_one_number():
    assert lanes.some(True)
    assert not lanes.every(False)
    assert lanes.choose(False, 1.0, 2.0) == 2.0
    assert lanes.whole(3.0) == 3


def test_operators_of_another_kind_stay_refused():
    @kernel
    def power(a):
        x = lanes.side_by_side(a)
        return lanes.bits(operator.pow(x[0], 2.0) > 1.0)

    with pytest.raises(numba.TypingError):
        power(np.ones((1, WIDTH)))
