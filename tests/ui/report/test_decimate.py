import numpy as np
import pytest

from cdpr.ui.report.plots.decimate import extrema, intervals


@pytest.mark.parametrize("rows", [2, 1201, 4001, 123_457])
def test_the_extremes_of_every_column_survive(rows: int) -> None:
    random = np.random.default_rng(rows)
    values = random.standard_normal((rows, 3))
    values[rows // 3, 0], values[2 * rows // 3, 1] = 1e3, -1e3  # peaks of one sample
    _, v = extrema(np.arange(rows) * 1e-3, values)
    assert np.array_equal(v.max(axis=0), values.max(axis=0))
    assert np.array_equal(v.min(axis=0), values.min(axis=0))
    assert len(v) <= 1202


def test_points_are_samples_in_the_order_of_time() -> None:
    time = np.arange(10_000) * 1e-3
    values = np.random.default_rng(0).standard_normal((10_000, 2))
    t, v = extrema(time, values, bins=50)
    assert np.all(np.diff(t, axis=0) >= 0.0)
    index = np.rint(t / 1e-3).astype(int)
    assert np.array_equal(v, np.take_along_axis(values, index, axis=0))
    assert np.array_equal(t[[0, -1]], [[0.0, 0.0], [time[-1], time[-1]]])


def test_few_samples_are_left_alone() -> None:
    time, values = np.arange(3.0), np.array([[1.0], [5.0], [2.0]])
    t, v = extrema(time, values)
    assert np.array_equal(t[:, 0], time)
    assert np.array_equal(v, values)


def test_non_finite_values_become_gaps() -> None:
    values = np.zeros((6000, 1))
    values[100] = 7.0
    values[101] = np.inf
    values[3000:4000] = np.nan
    t, v = extrema(np.arange(6000.0), values, bins=600)
    assert np.nanmax(v) == 7.0
    assert not np.isinf(v).any()
    assert np.isnan(v[(t > 3010) & (t < 3980)]).all()
    assert np.isfinite(v[(t < 2990) | (t > 4010)]).all()


def test_intervals_show_a_single_sample_and_join_neighbours() -> None:
    flags = np.zeros(60_000, dtype=bool)
    flags[100] = True
    flags[5000:6000:2] = True  # chatter
    flags[-1] = True
    assert intervals(flags, bins=600) == [(100, 300), (5000, 5999), (59_999, 60_199)]


def test_intervals_of_a_short_run_are_exact() -> None:
    assert intervals(np.array([True, True, False, False, True]), bins=600) == [(0, 2), (4, 5)]
    assert intervals(np.zeros(3, dtype=bool)) == []
    assert intervals(np.zeros(0, dtype=bool)) == []
