"""Restored simulations with thinned logs continue to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.log.mcap_file import PICTURE_ROWS

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
CABLE = {"robot.cable.diameter": 0.006, "robot.cables[0].length.max": 4.5}
THINNED = {"simulation.duration": 5.3, "log.step": 0.007, **CABLE}
EVENTS = [
    {"type": "cable_jam", "time": 0.6, "cable": 1, "detected_after": 0.02},
    {"type": "sine", "time": 0.01, "force": [50, 0, 0], "frequency": 20.0},
]
OVERRIDES = {**THINNED, "events": EVENTS}


def same(run, whole):
    assert run.rows.tobytes() == whole.rows.tobytes()
    assert run.summary() == whole.summary() | {"real_time_factor": run.summary()["real_time_factor"]}
    assert run.events == whole.events


@pytest.fixture(scope="module")
def whole():
    return cdpr.simulate(CAROCA, overrides=OVERRIDES)


@pytest.mark.parametrize("log", [False, True])
def test_it_continues_to_the_bit(whole, log, tmp_path):
    """The detours pass the end of the table of rows at hand, break a cable, and leave limits of tensions."""
    with cdpr.Simulation(CAROCA, overrides=OVERRIDES, out=tmp_path / "run" if log else None) as sim:
        sim.step(3)
        early = sim.snapshot()
        sim.step(600, tension=np.full(8, 5e5))
        sim.step(400, wrench=[0.0, 0.0, 750.0, 0.0, 0.0, 0.0])
        sim.cut(2)
        sim.step(30)
        aside = sim.snapshot()
        far = sim.row
        sim.restore(early)
        sim.step(1000)
        late = sim.snapshot()
        sim.step(PICTURE_ROWS)
        sim.restore(aside)
        assert sim.row.tobytes() == far.tobytes()
        sim.step(40)
        sim.restore(late)
        assert (sim.samples, len(sim.rows())) == (1003, 1)
        sim.step(500)
        assert len(sim.rows()) == 501
        sim.step(10000)
        same(sim.run(), whole)
    if log:
        same(cdpr.load_run(tmp_path / "run-4"), whole)


def test_so_far_equals_a_shorter_run(whole):
    with cdpr.Simulation(CAROCA, overrides=OVERRIDES) as sim:
        sim.step(700)
        here = sim.snapshot()
        sim.step(150, tension=np.full(8, 50.0))
        sim.restore(here)
        found = sim.so_far()
        with cdpr.Simulation(CAROCA, overrides=OVERRIDES) as other:
            other.step(700)
            expected = other.so_far()
    assert found.rows.tobytes() == expected.rows.tobytes()
    assert found.counted == expected.counted
    assert found.events == expected.events


def test_snapshots_of_a_thinned_run_are_small():
    """Otherwise, what is thinned to save memory would be in the snapshots."""
    with cdpr.Simulation(CAROCA, overrides=OVERRIDES) as sim:
        sizes = []
        for _ in range(8):
            sim.step(300)
            taken = sim.snapshot().samples
            sizes.append(taken.piece.rows.nbytes + taken.last.nbytes + taken.piece.status.nbytes)
        assert max(sizes) < 300 * sim.row.nbytes / 6
