"""External commands end with an emergency stop: of the user, of files, of batches and of clients."""

from __future__ import annotations

import numpy as np
import pytest
from driver_client import Client, ask

import cdpr
from cdpr.base.errors import CdprError

SHORT = {"simulation.duration": 0.1}
TENSION, WRENCH = np.full(8, 300.0), np.array([0.0, 0.0, 1500.0, 0.0, 0.0, 0.0])
COMMANDS = {"tension": TENSION, "wrench": WRENCH}
REFUSED = "step: the robot stops at {} s, and from then on wrenches and commands cannot replace"


def stop_at(time, category=2):
    return {"type": "emergency_stop", "time": time, "category": category}


@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize("category", [0, 1, 2])
def test_a_live_stop_ends_commands(kind, category):
    rows = []
    for refused in (True, False):
        with cdpr.Simulation("caroca", overrides=SHORT) as sim:
            sim.step(20, **{kind: COMMANDS[kind]})
            sim.stop(category)
            if refused:
                with pytest.raises(CdprError, match=REFUSED.format(0.02) + ".*: omit them"):
                    sim.step(1, **{kind: COMMANDS[kind]})
            sim.step(80)
            rows.append(sim.run().rows.tobytes())
    assert rows[0] == rows[1]


@pytest.mark.parametrize(("time", "before"), [(0.0504, 51), (0.1, 99), (0.0, 0)])
def test_steps_to_a_stop_of_the_scenario(time, before):
    """The last step also decides the last sample, so a stop there is in it."""
    with cdpr.Simulation("caroca", overrides={**SHORT, "events": [stop_at(time)]}) as sim:
        with pytest.raises(CdprError, match=f"take {before} steps with them" if before else "omit them"):
            sim.step(100, tension=TENSION)
        assert (sim.time, sim.steps_before_stop) == (0.0, before)
        if before:
            sim.step(before, tension=TENSION)
        with pytest.raises(CdprError, match="omit them"):
            sim.step(tension=TENSION)
        sim.step(100)
        assert ((sim.run().tension == TENSION).all(axis=1) == (np.arange(101) < before)).all()


def test_a_stop_after_the_end_changes_nothing():
    with cdpr.Simulation("caroca", overrides={**SHORT, "events": [stop_at(0.2)]}) as sim:
        sim.step(100, tension=TENSION)
        assert (sim.run().tension == TENSION).all()


def test_a_restore_from_before_the_stop_admits_commands_again():
    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        before = sim.snapshot()
        sim.stop()
        sim.restore(before)
        sim.step(100, tension=TENSION)
        assert (sim.run().tension == TENSION).all()


def test_commands_of_a_file_end_with_a_stop(tmp_path):
    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        sim.step(100, tension=TENSION)
        sim.save(tmp_path / "saved.yaml")
    with cdpr.Simulation(tmp_path / "saved.yaml") as sim:
        sim.step(30)
        sim.stop()
        sim.step(70)
        sim.save(tmp_path / "again.yaml")
        run = sim.run()
    assert ((run.tension == TENSION).all(axis=1) == (np.arange(101) < 30)).all()
    assert [(event.kind, event.until) for event in run.events][:1] == [("outside", pytest.approx(0.03))]
    assert cdpr.simulate(tmp_path / "again.yaml").rows.tobytes() == run.rows.tobytes()


def test_a_stop_ends_wrenches_of_a_batch():
    vary, overrides = {"robot.platform.mass": [60.0, 70.0]}, {**SHORT, "events": [stop_at(0.04)]}
    with cdpr.Batch("caroca", 2, vary=vary, overrides=overrides) as batch:
        batch.step(10, wrench=[WRENCH] * 2, mask=[False, True])
        batch.step(20, wrench=[WRENCH] * 2)
        rows = batch.rows.copy()
        with pytest.raises(CdprError, match=r"step: lane 1: the robot stops at 0\.04 s.*take 10 steps"):
            batch.step(20, wrench=[WRENCH] * 2)
        assert np.array_equal(batch.rows, rows)
        batch.step(20, wrench=[WRENCH] * 2, mask=[True, False])
        batch.step(20)
        assert batch.samples.tolist() == [60, 50]


def test_a_stop_of_the_scenario_ends_tensions_of_a_client():
    driver = Client(
        [(20, ask("tension", tension=[300.0] * 8)), (70, ask("tension", tension=[310.0] * 8))], events=[stop_at(0.05)]
    )
    driver.slice_steps = 7
    tension = driver.run().tension
    assert ((tension == 300.0).all(axis=1) == ((np.arange(101) >= 21) & (np.arange(101) < 50))).all()
    assert driver.said == [("error", "tension: the robot is stopped")]
