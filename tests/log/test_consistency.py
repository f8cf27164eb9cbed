"""Chi-square bands, and figures that do not depend on the size of batches."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from cdpr.log.consistency import Squares, band

QUANTILE = 1e-10  # relative error of a quantile
MANY = 2e-6  # that of the approximation for many degrees of freedom


@pytest.mark.parametrize("size", [1, 2, 3, 6, 7, 12, 41, 100])
def test_bands_are_those_of_scipy(size):
    np.testing.assert_allclose(band(size), stats.chi2.ppf([0.025, 0.975], size), rtol=QUANTILE)


@pytest.mark.parametrize("size", [1001, 5000, 240_000])
def test_bands_of_many_are_those_of_scipy(size):
    np.testing.assert_allclose(band(size), stats.chi2.ppf([0.025, 0.975], size), rtol=MANY)


def test_the_last_square_is_kept():
    squares, sizes = np.array([3.0, 5.0, np.nan]), np.array([2.0, 6.0, 0.0])
    figures = Squares().added(squares, sizes).added(squares[2:], sizes[2:]).figures()
    assert (figures["last"], figures["last_values"]) == (5.0, 6.0)


def test_consistent_squares():
    """Of 20000 numbers, 95 % are within the band, to four standard deviations."""
    rng = np.random.default_rng(1)
    sizes = rng.integers(1, 20, 20000).astype(float)
    figures = Squares().added(rng.chisquare(sizes), sizes).figures()
    assert figures is not None
    assert abs(figures["inside_95_percent"] - 0.95) < 4.0 * np.sqrt(0.95 * 0.05 / 20000)
    assert abs(figures["mean_per_value"] - 1.0) < 4.0 * np.sqrt(2.0 / sizes.sum())


def test_batches_of_any_size_give_equal_bits():
    rng = np.random.default_rng(2)
    squares, sizes = rng.chisquare(8.0, 1000), np.full(1000, 8.0)
    squares[::7], sizes[::7] = np.nan, 0.0
    whole, parts = Squares().added(squares, sizes), Squares()
    for first, last in ((0, 1), (1, 300), (300, 301), (301, 1000)):
        parts = parts.added(squares[first:last], sizes[first:last])
    assert parts == whole
    assert whole.samples == 857


def test_nothing_is_judged_without_samples():
    assert Squares().added(np.full(3, np.nan), np.zeros(3)).figures() is None
