"""Batches of example scenarios, and simulations to compare them with."""

from __future__ import annotations

import numpy as np
from conftest import ROOT

import cdpr

CAROCA, BREAK, WINCH = (ROOT / "scenarios" / f"{name}.yaml" for name in ("caroca", "cable_break", "winch"))
BRIEF = {"simulation.backend": "reference", "simulation.duration": 0.4, "simulation.ends_early": True}
N = 11  # lanes: a full block, and three in another
GAINS = np.linspace(80.0, 200.0, N)


def make(scenario=CAROCA, n=N, **more):
    given = {"vary": {"controller.kp": GAINS[:n]}, "overrides": BRIEF, **more}
    return cdpr.Batch(scenario, n, **given)


def alone(steps, scenario=CAROCA, **overrides):
    """Return a simulation after so many steps."""
    simulation = cdpr.Simulation(scenario, overrides={**BRIEF, **overrides})
    if steps:
        simulation.step(steps)
    return simulation


def assert_same(batch, lane, simulation):
    assert np.array_equal(batch.rows[:, lane], simulation._loop.row, equal_nan=True)
    assert batch.time[lane] == simulation.time
    assert batch.samples[lane] == simulation.samples


def assert_same_results(one, other):
    """Assert that two rollouts have the same bits."""
    assert one.status.tolist() == other.status.tolist()
    assert one.messages == other.messages
    assert np.array_equal(one.rows, other.rows, equal_nan=True)
    for name, values in one.figures.items():
        assert np.array_equal(values, other.figures[name], equal_nan=True), name
