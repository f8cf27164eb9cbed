"""Operations of the tension stage: rows, imposed tensions, commands and policies, against numpy and in lanes."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import LANES, assert_same_bits, run, run_lanes

from cdpr.native.bind import bind
from cdpr.tension.status import Status

EACH, M = 64, 8


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def problems(rng, n):
    limits = np.sort(rng.uniform(0.0, 400.0, (EACH, 2, M)), axis=1)
    limits[::5, 1, : M // 2] = limits[::5, 0, : M // 2]  # locked cables
    held = np.where(rng.random((EACH, M)) < 0.3, rng.uniform(0.0, 400.0, (EACH, M)), np.nan)
    return {"held": held, "limits": limits, "matrix": rng.normal(size=(EACH, n, M))}


def imposed(given, tension):
    """Return tensions and margin reports by numpy."""
    t = np.where(np.isnan(given["held"]), tension, given["held"])
    low, high = given["limits"][:, 0], given["limits"][:, 1]
    room = np.minimum(t - low, high - t)
    counts = np.isnan(given["held"]) & ~((low == high) & (room >= -1e-6))
    return t, np.where(counts, room, np.inf).min(axis=1), (counts & (room <= 1e-6)).sum(axis=1)


@pytest.mark.parametrize("runs", [run, run_lanes])
def test_imposed_tensions(rng, runs):
    given = problems(rng, 4)
    given |= {"wrench": rng.normal(size=(EACH, 4)), "weights": rng.uniform(0.3, 3.0, (EACH, 4))}
    before = {"tension": rng.uniform(0.0, 400.0, (EACH, M)), "report": np.full((EACH, 4), 7.0)}
    found, _ = runs("impose_tensions", given, {"tension": (M,), "report": (4,)}, before)
    t, margin, at_limit = imposed(given, before["tension"])
    residual = given["weights"] * (np.einsum("kji,ki->kj", given["matrix"], t) - given["wrench"])
    assert_same_bits(found["tension"], t)
    assert_same_bits(found["report"][:, 0], before["report"][:, 0])
    np.testing.assert_allclose(found["report"][:, 1], np.linalg.norm(residual, axis=1), rtol=1e-12)
    np.testing.assert_array_equal(found["report"][:, 2:], np.stack([margin, at_limit], axis=1))


@pytest.mark.parametrize("runs", [run, run_lanes])
def test_imposed_tensions_behind_a_command(rng, runs):
    given = problems(rng, 6)
    before = {"tension": rng.uniform(0.0, 400.0, (EACH, M)), "report": np.full((EACH, 4), 7.0)}
    found, _ = runs("impose_command", given, {"tension": (M,), "report": (4,), "wrench": (6,)}, before)
    t, margin, at_limit = imposed(given, before["tension"])
    assert_same_bits(found["tension"], t)
    np.testing.assert_allclose(found["wrench"], np.einsum("kji,ki->kj", given["matrix"], t), rtol=1e-12, atol=1e-9)
    np.testing.assert_array_equal(found["report"], np.stack([0.0 * margin + 7.0, 0.0 * margin, margin, at_limit], 1))


@pytest.mark.parametrize("runs", [run, run_lanes])
def test_room_within_the_limits(rng, runs):
    given, tension = problems(rng, 1), rng.uniform(0.0, 400.0, (EACH, M))
    inputs = {"limits": given["limits"], "tension": tension, "held": given["held"]}
    found, _ = runs("room_within_limits", inputs, {"room": (M,)})
    room = np.minimum(tension - given["limits"][:, 0], given["limits"][:, 1] - tension)
    np.testing.assert_array_equal(found["room"], np.where(np.isnan(given["held"]), room, np.nan))


@pytest.mark.parametrize("lanes", [(), (LANES,)])
def test_rows_of_the_degrees_of_freedom(rng, lanes):
    rows, W, wrench = np.array([0, 2, 4]), rng.normal(size=(6, M, *lanes)), rng.normal(size=(6, *lanes))
    chosen = {"matrix": np.empty((3, M, *lanes)), "wrench": np.empty((3, *lanes))}
    select = bind(
        "select_rows_lanes" if lanes else "select_rows", rows=rows, full_matrix=W, full_wrench=wrench, **chosen
    )
    assert select() == 0
    assert_same_bits(chosen["matrix"], W[rows])
    assert_same_bits(chosen["wrench"], wrench[rows])
    rows[1] = 6
    assert select() != 0


@pytest.mark.parametrize("stop", [0, 1])
def test_a_command_is_clipped(stop):
    limits, W = np.array([[1.0, 5.0, 0.0], [9.0, 5.0, 9.0]]), np.eye(6, 3)
    arrays = {
        "command": np.array([4.0, 70.0, 2.0]),
        "tension": np.zeros(3),
        "wrench": np.zeros(6),
        "report": np.zeros(4),
    }
    call = bind("take_command", limits=limits, matrix=W, stop=stop, **arrays)
    assert call() == Status.OK  # of a locked cable the command does not matter
    np.testing.assert_array_equal(arrays["tension"], [4.0, 5.0, 2.0])
    np.testing.assert_array_equal(arrays["wrench"], [4.0, 5.0, 2.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(arrays["report"], [Status.OK, 0.0, 2.0, 0.0])
    arrays["command"][0] = 9.5
    assert call() == (Status.NOT_FOUND if stop else Status.OK)
    np.testing.assert_array_equal(arrays["tension"], [9.0, 5.0, 2.0])
    np.testing.assert_array_equal(arrays["report"], [Status.NOT_FOUND, 0.0, 0.0, 1.0])
    arrays["command"][0] = np.nan
    assert call() == Status.BAD_INPUT
    np.testing.assert_array_equal(arrays["tension"], [9.0, 5.0, 2.0])
