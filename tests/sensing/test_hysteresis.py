"""Hysteresis of load cells: width of loops, memory, and a replay with play operators."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import CdprError
from cdpr.sensing import Tension
from cdpr.sensing.sensor import Sources

RANGE, SHARE = 2000.0, 0.01  # N, fraction of it
CELL = {"hysteresis": SHARE, "range": RANGE}
ROUND_OFF = 1e-9  # N: sums of thousands of small changes of tensions up to 2000 N
ELEMENTS = 4


def measured(tensions):
    """Return what a load cell without other errors measures of these tensions at consecutive control steps, from 0."""
    robot = cdpr.load_scenario("caroca").robot
    now, state = np.zeros(robot.m), np.zeros(13)
    about = state, np.zeros(3), 0.001, (), lambda *_: now, lambda _: False, lambda *_: ()
    truth = Tension(tension=CELL).truth(Sources(robot, *about))
    found = []
    for k, tension in enumerate(tensions):
        now[:] = tension
        for operation in truth.write:
            operation.do(0.001 * k)
        found.append(truth.values[0])
    return np.array(found)


def replay(tensions):
    """Return the same by play operators: each moves only if the tension leaves a band about it."""
    widths = 0.25 * RANGE * np.arange(1, ELEMENTS + 1) / ELEMENTS
    share, plays, found = 0.5 * SHARE * RANGE / widths.sum(), np.zeros(ELEMENTS), []
    for tension in tensions:
        plays = np.clip(plays, tension - widths, tension + widths)
        found.append(tension - share * np.sum(tension - plays))
    return np.array(found)


def ramp(*corners):
    return np.concatenate([[corners[0]], *(np.linspace(a, b, 401)[1:] for a, b in pairwise(corners))])


def test_the_largest_difference_of_a_whole_cycle_is_that_of_the_data_sheet():
    u = ramp(0.0, RANGE, 0.0, RANGE, 0.0)
    y = measured(u)
    rising, falling = y[800:1201], y[1200:1601][::-1]
    difference = falling - rising
    assert difference.max() == pytest.approx(SHARE * RANGE, abs=ROUND_OFF)
    assert difference[200] == pytest.approx(SHARE * RANGE, abs=ROUND_OFF)  # in the middle of the range
    assert difference[0] == pytest.approx(0.0, abs=ROUND_OFF)
    assert difference[-1] == pytest.approx(0.0, abs=ROUND_OFF)
    assert np.all(difference > -ROUND_OFF)  # the measured tension lags


def test_loops_close_and_larger_cycles_erase_smaller_ones():
    y = measured(ramp(0.0, 1500.0, 900.0, 1100.0, 900.0, 1500.0, 2000.0))
    assert y[800] == pytest.approx(y[1600], abs=ROUND_OFF)  # the small loop 900, 1100, 900
    assert y[400] == pytest.approx(y[2000], abs=ROUND_OFF)  # the larger one
    assert y[-1] == pytest.approx(measured(ramp(0.0, 2000.0))[-1], abs=ROUND_OFF)


@pytest.mark.parametrize("count", [500, pytest.param(50_000, marks=pytest.mark.slow)])
def test_random_tensions_equal_a_replay_with_play_operators(count):
    rng = np.random.default_rng(3)
    u = np.concatenate([[0.0], np.clip(500.0 + np.cumsum(rng.normal(0.0, 80.0, count)), 0.0, RANGE)])
    y = measured(u)
    assert np.abs(y - replay(u)).max() < ROUND_OFF
    assert np.abs(y - u).max() > 0.4 * SHARE * RANGE


def test_in_a_run_it_precedes_the_other_errors_and_is_in_snapshots_and_rollouts():
    caroca = str(ROOT / "scenarios" / "caroca.yaml")
    errors = {**CELL, "gain": 1.1, "bias": 2.0}
    overrides = {"simulation.duration": 0.1, "sensors": [{"type": "tension", "tension": errors, "period": 0.004}]}
    run = cdpr.simulate(caroca, overrides=overrides)
    true = np.vstack([np.zeros(8), run.tension[:-1]])
    expected = np.array([1.1 * replay(cable) + 2.0 for cable in true.T]).T
    held = 4 * (np.arange(101) // 4)
    assert np.abs(run["tension_tension"] - expected[held]).max() < ROUND_OFF
    with cdpr.Simulation(caroca, overrides=overrides) as simulation:
        simulation.step(30)
        snapshot = simulation.snapshot()
        simulation.step(20)
        simulation.restore(snapshot)
        simulation.step(71)
        assert simulation.run().rows.tobytes() == run.rows.tobytes()
    batch = cdpr.rollout(
        caroca, 4, vary={"simulation.seed": [0, 1, 2, 3]}, overrides=overrides, columns=["tension_tension"]
    )
    assert batch["tension_tension"][2].tobytes() == np.ascontiguousarray(run["tension_tension"]).tobytes()


def test_it_needs_a_range():
    with pytest.raises(CdprError, match="hysteresis without range"):
        Tension(tension={"hysteresis": 0.01})
