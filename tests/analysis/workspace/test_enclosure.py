"""Numbers enclosed over a box: against rational arithmetic at positions within it."""

from __future__ import annotations

from fractions import Fraction

import exact
import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from cdpr.analysis.workspace import enclosure

SIZES = st.floats(-1e6, 1e6, allow_subnormal=False)
SMALL = st.floats(0.0, 10.0, allow_subnormal=False)
MODELS = st.tuples(SIZES, SIZES, SIZES, SIZES, SMALL)
PLACES = st.tuples(*[st.sampled_from([-1.0, -0.5, 0.0, 0.3, 1.0])] * 4)


def value(model, place):
    """Return the value of a model at a place of the box; the last of these numbers takes its remainder."""
    c, x, y, z, r = map(Fraction, model)
    a, b, d, e = map(Fraction, place)
    return c + x * a + y * b + z * d + r * e


def encloses(model, place, number):
    return abs(number - value(model, (*place[:3], 0.0))) <= Fraction(model[4])


@given(MODELS, MODELS, PLACES, st.floats(-1.0, 1.0))
def test_sums_products_and_multiples(a, b, place, other):
    first, second = value(a, place), value(b, (*place[:3], other))
    found = enclosure.arithmetic([a], [b], [other])
    assert encloses(found.sum[0], place, first + second)
    assert encloses(found.product[0], place, first * second)
    assert encloses(found.multiple[0], place, first * Fraction(other))
    assert abs(first) <= Fraction(found.largest[0])


@given(
    st.tuples(*[st.floats(-20.0, 20.0)] * 3),
    st.tuples(*[st.floats(0.0, 3.0)] * 3),
    PLACES,
    st.sampled_from([0.0, 1e-13, 1e-3]),
)
@example(v=(0.0, 0.0, 8.4e-84), h=(0.0, 0.0, 0.0), place=(-1.0, -1.0, -1.0, -1.0), error=0.0)
def test_inverse_distances(v, h, place, error):
    (model,) = enclosure.inverse_distance([v], [h], [error])
    off = [Fraction(error) * sign for sign in (1, -1, 1)]
    w = [Fraction(a) + e - Fraction(b) * Fraction(s) for a, b, s, e in zip(v, h, place[:3], off, strict=True)]
    if np.isinf(model[4]):
        assert np.linalg.norm(v) <= np.linalg.norm(h) + 4.0 * error + 1e-9
        return
    near, far = exact.root(exact.dot(w, w))
    middle = value(model, (*place[:3], 0.0))
    assert middle - Fraction(model[4]) <= 1 / near
    assert middle + Fraction(model[4]) >= 1 / far


def test_the_rest_of_a_small_box_is_of_second_order():
    sides = [[h] * 3 for h in (1e-2, 1e-3)]
    rests = enclosure.inverse_distance([(3.0, 1.0, 2.0)] * 2, sides, [0.0, 0.0])[:, 4]
    assert 80.0 < rests[0] / rests[1] < 120.0
